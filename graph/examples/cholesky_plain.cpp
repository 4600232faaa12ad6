// The tiled Cholesky factor with MPI and TBB, column by column of tiles: factor the diagonal tile, solve for
// the column below it, send that to all ranks which need it, update what is right of it with all threads.
#include <oneapi/tbb/parallel_for_each.h>

#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "graph/examples/cholesky_problem.h"
#include "graph/examples/plain_world.h"

using namespace weft::examples;

namespace {

using Place = std::pair<int, int>;  ///< row and column of a tile
using Tiles = std::map<Place, std::vector<double>>;

class Cholesky final : public PlainProgram {
 public:
  explicit Cholesky(const Options& options) : size_(options.size), n_(options.tile), layout_(size_ / n_, 1) {
    if (size_ % n_ != 0) throw std::invalid_argument("--size must be a multiple of --tile");
  }

  void make(PlainRun& run) override {
    layout_ = cholesky::Layout(size_ / n_, run.ranks);
    layout_.for_tiles_of(run.rank, [&](int r, int c) { mine_[{r, c}] = cholesky::first_values(r, c, n_); });
  }

  void solve(PlainRun& run) override {
    for (int k = 0; k < layout_.tiles; ++k) {
      Tiles factors;  // of other ranks
      if (layout_.rank_of(k, k) == run.rank) cholesky::factor(tile({k, k}));
      exchange(run, k, k, k + 1, factors);
      solve_column(run, k, factors);
      exchange(run, k, k + 1, layout_.tiles, factors);
      update(run, k, factors);
    }
  }

  void write(PlainRun&, ResultFile& file) override {
    for (const auto& [place, values] : mine_)
      file.put(layout_.place(place.first, place.second) * values.size(), values);
  }

 private:
  cholesky::Tile tile(Place place) { return {mine_.at(place).data(), n_, n_}; }
  cholesky::ConstTile factor(Place place, const Tiles& factors) const {
    const auto found = factors.find(place);
    return {(found == factors.end() ? mine_.at(place) : found->second).data(), n_, n_};
  }

  /// The tiles of column k from row `begin` to `end` go to the ranks that use them.
  void exchange(PlainRun& run, int k, int begin, int end, Tiles& factors) {
    const std::size_t values = static_cast<std::size_t>(n_) * static_cast<std::size_t>(n_);
    for (int row = begin; row < end; ++row) {
      const int owner = layout_.rank_of(row, k);
      for (const int user : layout_.ranks_that_use(row, k)) {
        if (user == owner) continue;
        if (owner == run.rank) run.send(mine_.at({row, k}).data(), values * sizeof(double), user, row);
        if (user != run.rank) continue;
        std::vector<double>& place = factors[{row, k}];
        place.resize(values);
        run.receive(place.data(), values * sizeof(double), owner, row);
      }
    }
    run.wait_all();
  }

  /// Calls `call` with those of the tiles that are this rank's, on all threads.
  template <class Call>
  void for_each(PlainRun& run, const std::vector<Place>& places, const Call& call) {
    tbb::parallel_for_each(places, call);
    run.tasks += places.size();
  }

  void solve_column(PlainRun& run, int k, const Tiles& factors) {
    std::vector<Place> places;
    for (int row = k + 1; row < layout_.tiles; ++row)
      if (layout_.rank_of(row, k) == run.rank) places.emplace_back(row, k);
    for_each(run, places, [&](Place place) { cholesky::solve(tile(place), factor({k, k}, factors)); });
  }

  void update(PlainRun& run, int k, const Tiles& factors) {
    std::vector<Place> places;
    layout_.for_tiles_of(run.rank, [&](int r, int c) {
      if (c > k) places.emplace_back(r, c);
    });
    for_each(run, places, [&](Place place) {
      cholesky::update(tile(place), factor({place.first, k}, factors), factor({place.second, k}, factors));
    });
  }

  int size_, n_;  ///< rows; rows a tile
  cholesky::Layout layout_;
  Tiles mine_;
};

}  // namespace

int main(int argc, char** argv) {
  const Options options =
      options_of(argc, argv, "Tiled Cholesky factor, plain: rows, rows a tile", {.size = 2048, .tile = 128});
  Cholesky program(options);
  return run_plain(argc, argv, "cholesky_plain", options, program);
}
