// Particles on the engine: each cell is an instance that gets its neighbours' particles, moves its own, and
// hands over those that leave. Cells move to ranks that have nothing to do.
#include <optional>
#include <span>
#include <vector>

#include "engine/run/launch.h"
#include "graph/dataflow/blueprint.h"
#include "graph/examples/particles_problem.h"
#include "graph/examples/timed.h"

using namespace weft;
using namespace weft::examples;
using namespace weft::graph::dataflow;
using particles::Cells;
using particles::Particle;
using particles::Particles;

namespace {

struct Cell {
  Cells cells;
  int index = 0;
  std::uint64_t steps = 0;
  std::vector<Ref<Cell>> around;  ///< the cell itself too
  Particles own;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(cells, index, steps, around, own);
  }

  void show(NodeContext& context) {
    for (const Ref<Cell>& other : around) context.send<&Cell::move>(other, context.round(), own);
    const auto pairs = static_cast<double>(around.size() * own.size() * own.size());
    context.expect<&Cell::move>(context.round(), around, engine::Seconds{particles::kSecondsAPair * pairs});
  }

  void move(NodeContext& context, std::uint64_t round, std::vector<Arrival<Particles>> shown) {
    std::vector<std::span<const Particle>> others;
    for (const auto& arrival : shown) others.emplace_back(arrival.value);
    const std::array<int, 9> near = cells.around(index);
    std::vector<Particles> leaving(near.size());
    for (const Particle& p : particles::moved(own, others, 1.0 / cells.side)) {
      const auto to = std::find(near.begin(), near.end(), cells.cell(p));
      leaving.at(static_cast<std::size_t>(to - near.begin())).push_back(p);
    }
    for (std::size_t i = 0; i < around.size(); ++i)
      context.send<&Cell::settle>(around[i], round, std::move(leaving[i]));
    context.expect<&Cell::settle>(round, around);
  }

  std::optional<Nothing> settle(NodeContext&, std::uint64_t round, std::vector<Arrival<Particles>> come) {
    own.clear();
    for (const auto& arrival : come) own.insert(own.end(), arrival.value.begin(), arrival.value.end());
    particles::sort_by_id(own);
    return round + 1 < steps ? std::make_optional<Nothing>() : std::nullopt;
  }

  static Blueprint<Cell> blueprint() {
    Blueprint<Cell> g("cell");
    const auto show = g.start<&Cell::show>("show");
    const auto move = g.event<&Cell::move>("move");
    const auto settle = g.event<&Cell::settle>("settle");
    g.remote<Particles>(show, move);
    g.remote<Particles>(move, settle);
    g.local(settle, show, RoundStep::next);
    return g;
  }
};

Figures solve(engine::Transport& transport, const Options& options) {
  const Cells cells{options.tile};
  const int all = cells.side * cells.side, ranks = transport.size();
  const auto first_of = [&](int rank) { return (all * rank + ranks - 1) / ranks; };
  const auto ref = [&](int cell) {
    const int rank = cell * ranks / all;
    return Ref<Cell>{{engine::Rank(rank), static_cast<std::uint32_t>(cell - first_of(rank) + 1)}};
  };
  std::vector<Particles> at_first(static_cast<std::size_t>(all));
  for (std::int64_t id = 0; id < options.size; ++id)
    at_first[static_cast<std::size_t>(cells.cell(particles::first(id)))].push_back(particles::first(id));
  engine::Registry registry;
  register_blueprint<Cell>(registry);
  engine::Runtime runtime(
      transport, registry,
      {.threads = options.threads, .balancer = engine::balancer_by_name(options.balancer)});
  const auto for_cells = [&](const auto& call) {
    for (int i = first_of(transport.rank().value); i < first_of(transport.rank().value + 1); ++i) call(i);
  };
  const Figures figures = timed(
      runtime,
      [&](engine::Context& context) {
        for_cells([&](int i) {
          Cell cell{
              cells, i, static_cast<std::uint64_t>(options.steps), {}, at_first[static_cast<std::size_t>(i)]};
          for (const int near : cells.around(i)) cell.around.push_back(ref(near));
          create(context, std::move(cell));
        });
      },
      [&](engine::Context& context) { for_cells([&](int i) { start<&Cell::show>(context, ref(i)); }); });
  ResultFile file(options.out);
  visit<Cell>(runtime, [&](Ref<Cell>, Cell& cell) {
    for (const Particle& p : cell.own) file.put(2 * static_cast<std::size_t>(p.id), std::array{p.x, p.y});
  });
  return figures;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options =
      options_of(argc, argv, "Particles in a square, on the engine: particles, cells a side",
                 {.size = 20000, .tile = 16, .steps = 20, .balancer = "stealing"});
  return engine::launch(argc, argv, [&](engine::Transport& transport) {
    report(transport, "particles", options, solve(transport, options));
    return 0;
  });
}
