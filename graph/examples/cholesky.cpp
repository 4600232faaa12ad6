// A tiled Cholesky factor on the engine: each tile is a mobile object that is updated as soon as the factors
// of its row and column are there. A factor goes once to each rank that needs it, and there, without being
// copied, to all tiles.
#include <map>
#include <memory>
#include <stdexcept>
#include <vector>

#include "engine/run/launch.h"
#include "graph/examples/cholesky_problem.h"
#include "graph/examples/timed.h"

using namespace weft;
using namespace weft::examples;
using engine::Blob;
using engine::Context;
using engine::MobilePtr;
using engine::Rank;

namespace {

class Tile;

/// One a rank: passes factors on to its tiles.
struct Shelf {
  void put(Context& context, int row, int column, Blob factor);
};

/// What all objects of a rank share.
struct Known {
  cholesky::Layout layout;
  int tile = 0;

  /// A rank makes its shelf, number 1, and then its tiles.
  MobilePtr<Tile> at(int row, int column) const {
    return {{Rank(layout.rank_of(row, column)), layout.number(row, column) + 2}};
  }
};

const double* values_of(const Blob& blob) { return reinterpret_cast<const double*>(blob.data()); }

class Tile {
 public:
  Tile(int row, int column, int tile)
      : row_(row),
        column_(column),
        values_(std::make_shared<std::vector<double>>(cholesky::first_values(row, column, tile))) {}

  /// The first one has nothing to wait for.
  void begin(Context& context) { go_on(context); }

  /// Factor (of_row, k) has come: that of this tile's row, of its column, or both.
  void take(Context& context, int of_row, int k, Blob factor) {
    auto shared = std::make_shared<Blob>(std::move(factor));
    Operands& operands = operands_[k];
    if (of_row == row_) operands.left = shared;
    if (of_row == column_) operands.right = shared;
    go_on(context);
  }

  std::vector<double>& values() { return *values_; }
  int row() const { return row_; }
  int column() const { return column_; }

 private:
  struct Operands {
    std::shared_ptr<Blob> left, right;
  };

  /// Updates in the order of the columns, so that the sums are the same whatever comes first.
  void go_on(Context& context) {
    const int n = context.local<Known>().tile;
    const cholesky::Tile mine(values_->data(), n, n);
    for (; done_ < column_; ++done_) {
      const auto found = operands_.find(done_);
      if (found == operands_.end() || !found->second.left || !found->second.right) return;
      cholesky::update(mine, {values_of(*found->second.left), n, n}, {values_of(*found->second.right), n, n});
      operands_.erase(found);
    }
    if (row_ == column_) {
      cholesky::factor(mine);
    } else {
      if (!operands_[column_].right) return;
      cholesky::solve(mine, {values_of(*operands_[column_].right), n, n});
    }
    publish(context);
  }

  void publish(Context& context) {
    const auto* first = reinterpret_cast<const std::byte*>(values_->data());
    const Known& known = context.local<Known>();
    for (const int rank : known.layout.ranks_that_use(row_, column_))
      context.invoke<&Shelf::put>(MobilePtr<Shelf>{{Rank(rank), 1}}, row_, column_,
                                  Blob::share({first, values_->size() * sizeof(double)}, values_));
  }

  int row_, column_;
  int done_ = 0;  ///< columns whose update is done
  std::shared_ptr<std::vector<double>> values_;
  std::map<int, Operands> operands_;  ///< by column
};

void Shelf::put(Context& context, int row, int column, Blob factor) {
  const Known& known = context.local<Known>();
  const auto shared = std::make_shared<const Blob>(std::move(factor));
  known.layout.for_users_of(row, column, [&](int r, int c) {
    if (known.layout.rank_of(r, c) == context.rank().value)
      context.invoke<&Tile::take>(known.at(r, c), row, column, Blob::share(shared->bytes(), shared));
  });
}

Figures solve(engine::Transport& transport, const Options& options) {
  if (options.size % options.tile != 0) throw std::invalid_argument("--size must be a multiple of --tile");
  const Known known{{options.size / options.tile, transport.size()}, options.tile};
  engine::Registry registry;
  registry.type<Shelf>("Shelf").method<&Shelf::put>("put");
  registry.type<Tile>("Tile").method<&Tile::begin>("begin").method<&Tile::take>("take");
  engine::RuntimeOptions run{.threads = options.threads, .balancer = engine::no_balancing()};
  run.local = &known;
  engine::Runtime runtime(transport, registry, run);
  const int rank = transport.rank().value;
  const Figures figures = timed(
      runtime,
      [&](Context& context) {
        context.create<Shelf>();
        known.layout.for_tiles_of(rank, [&](int r, int c) { context.create<Tile>(r, c, options.tile); });
      },
      [&](Context& context) {
        if (rank == 0) context.invoke<&Tile::begin>(known.at(0, 0));
      });
  ResultFile file(options.out);
  runtime.visit<Tile>([&](MobilePtr<Tile>, Tile& tile) {
    file.put(known.layout.place(tile.row(), tile.column()) * tile.values().size(), tile.values());
  });
  return figures;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = options_of(argc, argv, "Tiled Cholesky factor, on the engine: rows, rows a tile",
                                     {.size = 2048, .tile = 128});
  return engine::launch(argc, argv, [&](engine::Transport& transport) {
    report(transport, "cholesky", options, solve(transport, options));
    return 0;
  });
}
