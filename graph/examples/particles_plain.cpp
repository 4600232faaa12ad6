// The particles with MPI and TBB: a rank has rows of cells, gets the rows beside its own, moves its particles
// with all its threads, and hands over those that leave. Ranks keep their rows.
#include <oneapi/tbb/parallel_for.h>

#include <stdexcept>
#include <vector>

#include "graph/examples/particles_problem.h"
#include "graph/examples/plain_world.h"

using namespace weft::examples;
using particles::Cells;
using particles::Particle;
using particles::Particles;

namespace {

class Movement final : public PlainProgram {
 public:
  explicit Movement(const Options& options)
      : count_(options.size),
        steps_(options.steps),
        cells_{options.tile},
        own_(number_of(cells_.side * cells_.side)) {}

  void make(PlainRun& run) override {
    if (cells_.side < 3 * run.ranks) throw std::invalid_argument("a rank must have three rows of cells");
    first_ = first_row(run.rank, run.ranks);
    end_ = first_row(run.rank + 1, run.ranks);
    for (std::int64_t id = 0; id < count_; ++id) {
      const Particle p = particles::first(id);
      if (is_mine(cells_.cell(p))) at(cells_.cell(p)).push_back(p);
    }
  }

  void solve(PlainRun& run) override {
    for (int k = 0; k < steps_; ++k) {
      get_rows_beside(run);
      const std::vector<Particles> moved = move(run);
      settle(run, moved);
    }
  }

  void write(PlainRun&, ResultFile& file) override {
    for (int cell = first_ * cells_.side; cell < end_ * cells_.side; ++cell)
      for (const Particle& p : at(cell))
        file.put(2 * number_of(static_cast<int>(p.id)), std::array{p.x, p.y});
  }

 private:
  static std::size_t number_of(int i) { return static_cast<std::size_t>(i); }
  int first_row(int rank, int ranks) const { return (cells_.side * rank + ranks - 1) / ranks; }
  bool is_mine(int cell) const { return cell >= first_ * cells_.side && cell < end_ * cells_.side; }
  Particles& at(int cell) { return own_[number_of(cell)]; }
  int row(int r) const { return (r + cells_.side) % cells_.side; }

  /// Sends `up` to the rank above and `down` to the one below, and appends what they send. With one rank, or
  /// two, both neighbours are the same rank: tags tell the directions.
  static void swap(PlainRun& run, const Particles& up, const Particles& down, Particles& from_above,
                   Particles& from_below) {
    const int above = (run.rank + run.ranks - 1) % run.ranks, below = (run.rank + 1) % run.ranks;
    const std::size_t sends[2] = {up.size(), down.size()};
    std::size_t comes[2] = {};
    run.receive(&comes[0], sizeof comes[0], above, 1);
    run.receive(&comes[1], sizeof comes[1], below, 0);
    run.send(&sends[0], sizeof sends[0], above, 0);
    run.send(&sends[1], sizeof sends[1], below, 1);
    run.wait_all();
    from_above.resize(comes[0]);
    from_below.resize(comes[1]);
    run.receive(from_above.data(), comes[0] * sizeof(Particle), above, 3);
    run.receive(from_below.data(), comes[1] * sizeof(Particle), below, 2);
    run.send(up.data(), up.size() * sizeof(Particle), above, 2);
    run.send(down.data(), down.size() * sizeof(Particle), below, 3);
    run.wait_all();
  }

  void get_rows_beside(PlainRun& run) {
    if (run.ranks == 1) return;
    Particles up, down, from_above, from_below;
    for (int c = 0; c < cells_.side; ++c) {
      const Particles &top = at(first_ * cells_.side + c), &bottom = at((end_ - 1) * cells_.side + c);
      up.insert(up.end(), top.begin(), top.end());
      down.insert(down.end(), bottom.begin(), bottom.end());
      at(row(first_ - 1) * cells_.side + c).clear();
      at(row(end_) * cells_.side + c).clear();
    }
    swap(run, up, down, from_above, from_below);
    for (const Particle& p : from_above)
      at(cells_.cell(p)).push_back(p);  // in the order of their ids, cell by cell
    for (const Particle& p : from_below) at(cells_.cell(p)).push_back(p);
  }

  std::vector<Particles> move(PlainRun& run) {
    const int begin = first_ * cells_.side, end = end_ * cells_.side;
    std::vector<Particles> moved(number_of(end - begin));
    tbb::parallel_for(begin, end, [&](int cell) {
      std::vector<std::span<const Particle>> others;
      for (const int near : cells_.around(cell)) others.emplace_back(at(near));
      moved[number_of(cell - begin)] = particles::moved(at(cell), others, 1.0 / cells_.side);
    });
    run.tasks += moved.size();
    return moved;
  }

  void settle(PlainRun& run, const std::vector<Particles>& moved) {
    for (Particles& cell : own_) cell.clear();
    Particles up, down, from_above, from_below;
    for (const Particles& cell : moved)
      for (const Particle& p : cell) {
        const int to = cells_.cell(p);
        if (is_mine(to)) {
          at(to).push_back(p);
        } else {
          (to / cells_.side == row(first_ - 1) ? up : down).push_back(p);
        }
      }
    if (run.ranks > 1) swap(run, up, down, from_above, from_below);
    for (const Particle& p : from_above) at(cells_.cell(p)).push_back(p);
    for (const Particle& p : from_below) at(cells_.cell(p)).push_back(p);
    for (Particles& cell : own_) particles::sort_by_id(cell);
  }

  int count_, steps_, first_ = 0, end_ = 0;  ///< rows of cells from `first_` to `end_` are this rank's
  Cells cells_;
  std::vector<Particles> own_;  ///< by cell; of other ranks those beside, for a step
};

}  // namespace

int main(int argc, char** argv) {
  const Options options = options_of(argc, argv, "Particles in a square, plain: particles, cells a side",
                                     {.size = 20000, .tile = 16, .steps = 20});
  Movement program(options);
  return run_plain(argc, argv, "particles_plain", options, program);
}
