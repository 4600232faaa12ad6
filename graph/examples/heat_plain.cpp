// The heat stencil with MPI and TBB: a rank has a strip of the grid, exchanges its outer rows, then takes the
// step with all its threads.
#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/parallel_for.h>

#include <stdexcept>
#include <vector>

#include "graph/examples/heat_problem.h"
#include "graph/examples/plain_world.h"

using namespace weft::examples;

namespace {

class Heat final : public PlainProgram {
 public:
  explicit Heat(const Options& options)
      : size_(static_cast<std::size_t>(options.size)),
        tile_(static_cast<std::size_t>(options.tile)),
        steps_(options.steps) {
    if (size_ % tile_ != 0) throw std::invalid_argument("--size must be a multiple of --tile");
  }

  void make(PlainRun& run) override {
    const std::size_t side = size_ / tile_;
    if (side < static_cast<std::size_t>(run.ranks))
      throw std::invalid_argument("fewer rows of blocks than ranks");
    first_ = tile_ * heat::first_row_of(run.rank, run.ranks, side);
    rows_ = tile_ * heat::first_row_of(run.rank + 1, run.ranks, side) - first_;
    now_.resize((rows_ + 2) * (size_ + 2));
    next_ = now_;
    for (std::size_t r = 0; r < rows_; ++r)
      for (std::size_t c = 0; c < size_; ++c) now_[place(r, c)] = heat::first_value(first_ + r, c);
  }

  void solve(PlainRun& run) override {
    for (int k = 0; k < steps_; ++k) {
      exchange(run);
      step(run);
    }
  }

  void write(PlainRun&, ResultFile& file) override {
    for (std::size_t r = 0; r < rows_; ++r) file.put((first_ + r) * size_, {&now_[place(r, 0)], size_});
  }

 private:
  std::size_t place(std::size_t r, std::size_t c) const { return (r + 1) * (size_ + 2) + c + 1; }

  void exchange(PlainRun& run) {
    const std::size_t bytes = size_ * sizeof(double);
    const auto with = [&](int other, std::size_t mine, std::size_t theirs) {
      if (other < 0 || other >= run.ranks) return;
      run.receive(&now_[theirs], bytes, other, 0);
      run.send(&now_[mine], bytes, other, 0);
    };
    with(run.rank - 1, place(0, 0), place(0, 0) - (size_ + 2));
    with(run.rank + 1, place(rows_ - 1, 0), place(rows_, 0));
    run.wait_all();
  }

  void step(PlainRun& run) {
    const std::size_t down = rows_ / tile_, across = size_ / tile_;
    tbb::parallel_for(tbb::blocked_range2d<std::size_t>(0, down, 1, 0, across, 1), [&](const auto& range) {
      for (std::size_t r = range.rows().begin(); r < range.rows().end(); ++r)
        for (std::size_t c = range.cols().begin(); c < range.cols().end(); ++c) {
          const std::size_t corner = place(r * tile_, c * tile_);
          heat::step(&now_[corner], &next_[corner], tile_, tile_, size_ + 2);
        }
    });
    run.tasks += down * across;
    now_.swap(next_);
  }

  std::size_t size_, tile_;
  int steps_;
  std::size_t first_ = 0, rows_ = 0;  ///< of this rank
  std::vector<double> now_, next_;    ///< with one more point on each side
};

}  // namespace

int main(int argc, char** argv) {
  const Options options = options_of(argc, argv, "Heat in a square, plain: points a side, points a block",
                                     {.size = 1024, .tile = 128, .steps = 100});
  Heat program(options);
  return run_plain(argc, argv, "heat_plain", options, program);
}
