// write_sample FOLDER SUBDOMAINS RANKS WORKERS ROUNDS SEED CELLS: profile.json, graph.json and report.html of
// a simulated run, for the tests that look at the page and the dumps from outside.
#include <cstdio>
#include <fstream>
#include <string>

#include "engine/json/json.h"
#include "graph/dataflow/dump/graph_json.h"
#include "tests/tools/report/sample_run.h"
#include "tools/report/report_page.h"

int main(int argc, char** argv) {
  if (argc != 8) {
    std::fprintf(stderr, "usage: write_sample FOLDER SUBDOMAINS RANKS WORKERS ROUNDS SEED CELLS\n");
    return 64;
  }
  const auto number = [&](int i) { return static_cast<std::uint32_t>(std::stoul(argv[i])); };
  const std::string folder = argv[1];
  const auto sample = weft::testing::sample_run({.subdomains = number(2),
                                                 .ranks = number(3),
                                                 .workers = number(4),
                                                 .rounds = number(5),
                                                 .seed = number(6)},
                                                number(7));
  std::ofstream(folder + "/profile.json") << sample.profile.dump() << '\n';
  std::ofstream(folder + "/graph.json") << weft::graph::dataflow::json_of(sample.graph).dump() << '\n';
  std::ofstream(folder + "/report.html") << weft::report::report_page(sample.profile);
  return 0;
}
