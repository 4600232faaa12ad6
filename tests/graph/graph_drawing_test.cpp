// Drawings: every run, once; and the text formats around names with all kinds of characters.
#include "graph/dataflow/dump/graph_drawing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <pugixml.hpp>
#include <set>

#include "graph/dataflow/dump/critical_path.h"
#include "graph/dataflow/dump/graph_files.h"
#include "tests/support/simulated_run.h"

namespace weft::graph::dataflow::graph_drawing_test {
namespace {

GraphDump dump_of(const weft::testing::SimulationRules& rules) {
  const weft::testing::SimulatedRun run = weft::testing::simulate(rules);
  return executed_dump(run.graph, run.log, [&](engine::ObjectId object) {
    return weft::testing::subdomain_of_object(rules, object);
  });
}

GraphDump sample() {
  return dump_of({.subdomains = 9, .ranks = 3, .rounds = 3, .migration = true, .seed = 3});
}

double attribute(const std::vector<Attribute>& attributes, const std::string& name) {
  for (const auto& [key, value] : attributes) {
    if (key != name) continue;
    if (const auto* n = std::get_if<std::int64_t>(&value)) return static_cast<double>(*n);
    return std::get<double>(value);
  }
  ADD_FAILURE() << "no attribute " << name;
  return 0;
}

TEST(GraphDrawing, ShowsEachRunInTheClusterOfItsRank) {
  const GraphDump dump = sample();
  const Drawing drawing = drawing_of(dump, Collapse::none, "subdomain");
  ASSERT_EQ(drawing.vertices.size(), dump.runs.size());
  std::set<std::string> ids;
  for (std::size_t r = 0; r < dump.runs.size(); ++r) {
    const DrawnVertex& vertex = drawing.vertices[r];
    EXPECT_TRUE(ids.insert(vertex.id).second);
    EXPECT_EQ(drawing.clusters[*vertex.cluster], "rank " + std::to_string(dump.runs[r].rank.value));
    EXPECT_EQ(attribute(vertex.attributes, "round"), static_cast<double>(dump.runs[r].round));
    EXPECT_EQ(attribute(vertex.attributes, "seconds"),
              1e-9 * static_cast<double>(dump.runs[r].end - dump.runs[r].begin));
  }
}

TEST(GraphDrawing, MarksTheCriticalPathAsOneChain) {
  const GraphDump dump = sample();
  const Drawing drawing = drawing_of(dump, Collapse::none, "subdomain");
  std::size_t edges = 0;
  for (const DrawnEdge& edge : drawing.edges) {
    if (!edge.critical) continue;
    ++edges;
    EXPECT_TRUE(drawing.vertices[edge.from].critical && drawing.vertices[edge.to].critical);
  }
  EXPECT_EQ(edges + 1, dump.critical_path.steps.size());
}

/// Whatever the runs are collapsed to, no second, run or byte is lost.
TEST(GraphDrawing, KeepsTheSumsWhereRunsAreCollapsed) {
  const GraphDump dump = sample();
  double spent = 0, bytes = 0;
  for (const DumpedRun& run : dump.runs) spent += 1e-9 * static_cast<double>(run.end - run.begin);
  for (const DumpedUse& use : dump.uses) bytes += static_cast<double>(use.bytes);
  for (const Collapse collapse : {Collapse::rounds, Collapse::instances}) {
    const Drawing drawing = drawing_of(dump, collapse, "subdomain");
    double drawn = 0, runs = 0, sent = 0;
    for (const DrawnVertex& vertex : drawing.vertices) {
      drawn += attribute(vertex.attributes, "seconds");
      runs += attribute(vertex.attributes, "runs");
      EXPECT_LE(vertex.weight, 1);
    }
    for (const DrawnEdge& edge : drawing.edges) sent += attribute(edge.attributes, "bytes");
    EXPECT_NEAR(drawn, spent, 1e-9 * spent);
    EXPECT_EQ(runs, static_cast<double>(dump.runs.size()));
    EXPECT_EQ(sent, bytes);
  }
  EXPECT_EQ(drawing_of(dump, Collapse::instances, "subdomain").vertices.size(), dump.instances.size());
}

TEST(GraphDrawing, JoinsWhatTwoInstancesExchange) {
  const GraphDump dump = sample();
  const Drawing network = drawing_of(dump, Collapse::instances, "subdomain");
  const Drawing joined = joined_edges(network);
  double sent = 0, between = 0;
  for (const DrawnEdge& edge : network.edges)
    if (edge.from != edge.to) sent += attribute(edge.attributes, "bytes");
  std::set<std::pair<std::size_t, std::size_t>> pairs;
  for (const DrawnEdge& edge : joined.edges) {
    EXPECT_LT(edge.from, edge.to);
    pairs.insert({edge.from, edge.to});
    between += attribute(edge.attributes, "bytes");
  }
  EXPECT_EQ(pairs.size(), joined.edges.size()) << "one a pair";
  EXPECT_LT(joined.edges.size(), network.edges.size() / 2);
  EXPECT_EQ(between, sent);
}

TEST(Dot, LaysOutLargeNetworksBySprings) {
  GraphDump dump = sample();
  EXPECT_NE(dot_of(drawing_of(dump, Collapse::instances, "subdomain")).find("cluster_0"), std::string::npos);
  while (dump.instances.size() < 100) dump.instances.push_back({dump.instances.size(), {}, engine::Rank(1)});
  std::vector<std::pair<InstanceIndex, InstanceIndex>> neighbours;
  for (InstanceIndex i = 1; i < dump.instances.size(); ++i) neighbours.emplace_back(i - 1, i);
  const GraphDump plan = planned_dump(dump.description, dump.instances, neighbours);
  const std::string text = dot_of(drawing_of(plan, Collapse::instances, "subdomain"));
  EXPECT_NE(text.find("sfdp"), std::string::npos);
  EXPECT_NE(text.find("rank 1"), std::string::npos) << "said by the labels, as there are no clusters";
}

TEST(GraphDrawing, ShowsAPlannedGraphByNodesOrByInstances) {
  const GraphDump dump = sample();
  const GraphDump plan = planned_dump(dump.description, dump.instances, {{0, 1}, {1, 0}, {2, 0}});
  const std::size_t nodes = dump.description.nodes.size(), edges = dump.description.edges.size();
  EXPECT_EQ(drawing_of(dump.description).vertices.size(), nodes);
  EXPECT_EQ(drawing_of(dump.description).edges.size(), edges);
  const Drawing by_nodes = drawing_of(plan, Collapse::none, "subdomain");
  EXPECT_EQ(by_nodes.vertices.size(), 3 * nodes);
  const Drawing by_instances = drawing_of(plan, Collapse::instances, "subdomain");
  EXPECT_EQ(by_instances.vertices.size(), 3u);
  EXPECT_EQ(by_instances.edges.size(), plan.network.size());
  EXPECT_EQ(drawing_of(planned_dump(dump.description, dump.instances, {}), Collapse::instances, "subdomain")
                .vertices.size(),
            9u);
}

GraphDump strange_names() {
  GraphDump dump = sample();
  dump.description.name = "a \"graph\" & <more>";
  dump.description.nodes[0].name = "back\\slash \"quoted\"\nline";
  dump.description.nodes[1].name = "<b>&amp;</b> ]]> é";
  return dump;
}

TEST(Graphml, IsWellFormedAndHoldsAllVerticesAndEdges) {
  for (const Collapse collapse : {Collapse::none, Collapse::rounds, Collapse::instances}) {
    const GraphDump dump = strange_names();
    const Drawing drawing = drawing_of(dump, collapse, "subdomain");
    pugi::xml_document document;
    const std::string text = graphml_of(drawing);
    ASSERT_TRUE(document.load_string(text.c_str()));
    const pugi::xml_node graph = document.child("graphml").child("graph");
    EXPECT_EQ(graph.attribute("id").value(), dump.description.name);
    std::set<std::string> ids;
    for (const pugi::xml_node node : graph.children("node")) ids.insert(node.attribute("id").value());
    EXPECT_EQ(ids.size(), drawing.vertices.size());
    std::size_t edges = 0;
    for (const pugi::xml_node edge : graph.children("edge")) {
      EXPECT_TRUE(ids.contains(edge.attribute("source").value()));
      EXPECT_TRUE(ids.contains(edge.attribute("target").value()));
      ++edges;
    }
    EXPECT_EQ(edges, drawing.edges.size());
  }
}

TEST(Graphml, TypesEveryAttribute) {
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(graphml_of(drawing_of(sample(), Collapse::none, "subdomain")).c_str()));
  std::map<std::string, std::string> types;
  for (const pugi::xml_node key : document.child("graphml").children("key"))
    types[key.attribute("attr.name").value()] = key.attribute("attr.type").value();
  EXPECT_EQ(types["seconds"], "double");
  EXPECT_EQ(types["round"], "long");
  EXPECT_EQ(types["subdomain"], "long");
  EXPECT_EQ(types["label"], "string");
  EXPECT_EQ(types["tets, interior"], "double");
}

TEST(Dot, QuotesNamesAndMarksTheCriticalPath) {
  const std::string text = dot_of(drawing_of(strange_names(), Collapse::none, "subdomain"));
  EXPECT_THAT(text, ::testing::StartsWith("digraph \"a \\\"graph\\\" & <more>\" {\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("back\\\\slash \\\"quoted\\\"\\nline"));
  EXPECT_THAT(text, ::testing::HasSubstr("label=\"rank 2\""));
  EXPECT_THAT(text, ::testing::HasSubstr("penwidth"));
  EXPECT_THAT(text, ::testing::EndsWith("}\n"));
}

}  // namespace
}  // namespace weft::graph::dataflow::graph_drawing_test
