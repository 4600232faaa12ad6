// A first program with weft's engine: a token visits objects all over the run, which move around meanwhile.
#include <cstdio>
#include <vector>

#include "engine/run/launch.h"
#include "engine/run/runtime.h"

using namespace weft::engine;

struct Station {
  std::vector<ObjectId> line;  // all stations
  int visits = 0;

  template <class Archive>
  void serialize(Archive& archive) {  // what a station is when it moves to another rank
    archive(line, visits);
  }

  void know(Context&, const std::vector<ObjectId>& all) { line = all; }

  void visit(Context& context, int hops_left) {
    ++visits;
    if (hops_left > 0)
      context.invoke<&Station::visit>(MobilePtr<Station>{line[hops_left % line.size()]}, hops_left - 1);
  }
};

int main(int argc, char** argv) {
  return launch(argc, argv, [](Transport& transport) {
    Registry registry;
    registry.type<Station>("Station").method<&Station::know>("know").method<&Station::visit>("visit");
    Runtime runtime(transport, registry, {.threads = 1, .balancer = rotate()});
    runtime.run([](Context& context) {  // on every rank; the run lasts until no message is left
      if (context.rank() != Rank(0)) return;
      std::vector<ObjectId> all;
      for (int i = 0; i < 10; ++i) all.push_back(context.create<Station>().id);
      for (const ObjectId id : all) context.invoke<&Station::know>(MobilePtr<Station>{id}, all);
      context.invoke<&Station::visit>(MobilePtr<Station>{all[0]}, 1000);
    });
    runtime.visit<Station>([&](MobilePtr<Station> station, Station& state) {
      std::printf("rank %d: station %u had %d visits\n", transport.rank().value, station.id.number,
                  state.visits);
    });
    return 0;
  });
}
