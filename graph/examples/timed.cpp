// Differences of summaries.
#include "graph/examples/timed.h"

namespace weft::examples {
namespace {

struct Sum {
  double value = 0;
  void add(engine::Context&, double term) { value += term; }
};

std::uint64_t handlers_of(const engine::RunSummary& run) {
  std::uint64_t count = 0;
  for (const engine::MethodSummary& method : run.methods) count += method.count;
  return count;
}

engine::MessageCount sent(const engine::RunSummary& run) {
  engine::MessageCount all;
  for (const engine::Volume& traffic : run.traffic) {
    all.messages += traffic.sent.messages;
    all.bytes += traffic.sent.bytes;
  }
  return all;
}

std::uint64_t moves(const engine::RunSummary& run) {
  return run.traffic[static_cast<std::size_t>(engine::Traffic::migrate)].sent.messages;
}

}  // namespace

Figures timed(engine::Runtime& runtime, const std::function<void(engine::Context&)>& make,
              const std::function<void(engine::Context&)>& go) {
  runtime.run(make);
  const engine::RunSummary before = runtime.gather_sums();
  const double wall = wall_clock(), processor = processor_seconds();
  runtime.run(go);
  Figures figures;
  figures.seconds = wall_clock() - wall;
  figures.processor = processor_seconds() - processor;
  const engine::RunSummary after = runtime.gather_sums();
  figures.tasks = handlers_of(after) - handlers_of(before);
  figures.messages = sent(after).messages - sent(before).messages;
  figures.bytes = sent(after).bytes - sent(before).bytes;
  figures.moves = moves(after) - moves(before);
  return figures;
}

void report(engine::Transport& transport, const std::string& program, const Options& options,
            Figures figures) {
  engine::Registry registry;
  registry.type<Sum>("Sum").method<&Sum::add>("add");
  engine::Runtime runtime(transport, registry, {.balancer = engine::no_balancing()});
  runtime.run([&](engine::Context& context) {
    if (context.rank() == engine::Rank(0)) context.create<Sum>();
    context.invoke<&Sum::add>(engine::MobilePtr<Sum>{{engine::Rank(0), 1}}, figures.processor);
  });
  runtime.visit<Sum>([&](engine::MobilePtr<Sum>, Sum& sum) { figures.processor = sum.value; });
  if (transport.rank() == engine::Rank(0)) print(program, transport.size(), options, figures);
}

}  // namespace weft::examples
