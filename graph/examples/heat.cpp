// A heat stencil as a task graph: each block of the grid is an instance that sends its edges to its
// neighbours and takes its step when theirs have come. No block waits for any but its neighbours.
#include <optional>
#include <stdexcept>
#include <vector>

#include "engine/run/launch.h"
#include "graph/dataflow/blueprint.h"
#include "graph/examples/heat_problem.h"
#include "graph/examples/timed.h"

using namespace weft;
using namespace weft::examples;
using namespace weft::graph::dataflow;
using Values = std::vector<double>;

namespace {

struct Block;

/// The grid in side x side blocks of tile x tile points; ranks have rows of blocks.
struct Layout {
  std::size_t side = 0, tile = 0, steps = 0;
  int ranks = 1;

  /// Objects of a rank are numbered in the order in which they are made, from 1.
  Ref<Block> block(std::size_t row, std::size_t column) const {
    const int rank = heat::rank_of_row(row, ranks, side);
    const std::size_t place = (row - heat::first_row_of(rank, ranks, side)) * side + column;
    return {{engine::Rank(rank), static_cast<std::uint32_t>(place + 1)}};
  }
};

enum class Side { above, below, left, right };

struct Block {
  Layout layout;
  std::size_t row = 0, column = 0;
  Values now, next;  ///< with one more point on each side
  std::vector<Ref<Block>> neighbours;
  std::vector<Side> sides;  ///< of these

  Block() = default;
  Block(const Layout& of, std::size_t in_row, std::size_t in_column)
      : layout(of), row(in_row), column(in_column), now(stride() * stride()), next(now) {
    for (std::size_t r = 0; r < layout.tile; ++r)
      for (std::size_t c = 0; c < layout.tile; ++c)
        now[place(r, c)] = heat::first_value(row * layout.tile + r, column * layout.tile + c);
    const auto add = [&](Side side, std::size_t r, std::size_t c) {
      neighbours.push_back(layout.block(r, c));
      sides.push_back(side);
    };
    if (row > 0) add(Side::above, row - 1, column);
    if (row + 1 < layout.side) add(Side::below, row + 1, column);
    if (column > 0) add(Side::left, row, column - 1);
    if (column + 1 < layout.side) add(Side::right, row, column + 1);
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(layout, row, column, now, next, neighbours, sides);
  }

  void send_edges(NodeContext& context) {
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      Values edge(layout.tile);
      for (std::size_t k = 0; k < edge.size(); ++k) edge[k] = now[on_edge(sides[i], k)];
      context.send<&Block::update>(neighbours[i], context.round(), std::move(edge));
    }
    context.expect<&Block::update>(context.round(), neighbours);
  }

  std::optional<Nothing> update(NodeContext&, std::uint64_t round, std::vector<Arrival<Values>> edges) {
    for (std::size_t i = 0; i < edges.size(); ++i)
      for (std::size_t k = 0; k < layout.tile; ++k) now[on_halo(sides[i], k)] = edges[i].value[k];
    heat::step(&now[place(0, 0)], &next[place(0, 0)], layout.tile, layout.tile, stride());
    now.swap(next);
    return round + 1 < layout.steps ? std::make_optional<Nothing>() : std::nullopt;
  }

  static Blueprint<Block> blueprint() {
    Blueprint<Block> g("block");
    const auto send_edges = g.start<&Block::send_edges>("send edges");
    const auto update = g.event<&Block::update>("update");
    g.remote<Values>(send_edges, update);
    g.local(update, send_edges, RoundStep::next);
    return g;
  }

  std::size_t stride() const { return layout.tile + 2; }
  std::size_t place(std::size_t r, std::size_t c) const { return (r + 1) * stride() + c + 1; }
  std::size_t on_edge(Side side, std::size_t k) const {
    if (side == Side::above || side == Side::below)
      return place(side == Side::above ? 0 : layout.tile - 1, k);
    return place(k, side == Side::left ? 0 : layout.tile - 1);
  }
  std::size_t on_halo(Side side, std::size_t k) const {
    if (side == Side::above || side == Side::left)
      return on_edge(side, k) - (side == Side::above ? stride() : 1);
    return on_edge(side, k) + (side == Side::below ? stride() : 1);
  }
};

Figures solve(engine::Transport& transport, const Options& options) {
  if (options.size % options.tile != 0) throw std::invalid_argument("--size must be a multiple of --tile");
  const auto size = static_cast<std::size_t>(options.size), tile = static_cast<std::size_t>(options.tile);
  const Layout layout{size / tile, tile, static_cast<std::size_t>(options.steps), transport.size()};
  engine::Registry registry;
  register_blueprint<Block>(registry);
  engine::Runtime runtime(
      transport, registry,
      {.threads = options.threads, .balancer = engine::balancer_by_name(options.balancer)});
  const int rank = transport.rank().value;
  const auto each_block = [&](const auto& call) {
    for (std::size_t r = heat::first_row_of(rank, layout.ranks, layout.side);
         r < heat::first_row_of(rank + 1, layout.ranks, layout.side); ++r)
      for (std::size_t c = 0; c < layout.side; ++c) call(r, c);
  };
  const Figures figures = timed(
      runtime,
      [&](engine::Context& context) {
        each_block([&](std::size_t r, std::size_t c) { create(context, Block(layout, r, c)); });
      },
      [&](engine::Context& context) {
        each_block([&](auto r, auto c) { start<&Block::send_edges>(context, layout.block(r, c)); });
      });
  ResultFile file(options.out);
  visit<Block>(runtime, [&](Ref<Block>, Block& block) {
    for (std::size_t r = 0; r < tile; ++r)
      file.put((block.row * tile + r) * size + block.column * tile, {&block.now[block.place(r, 0)], tile});
  });
  return figures;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options =
      options_of(argc, argv, "Heat in a square, on the engine: points a side, points a block",
                 {.size = 1024, .tile = 128, .steps = 100, .balancer = "none"});
  return engine::launch(argc, argv, [&](engine::Transport& transport) {
    report(transport, "heat", options, solve(transport, options));
    return 0;
  });
}
