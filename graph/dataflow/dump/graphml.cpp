// XML by pugixml, which escapes what names contain.
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "engine/base/text.h"
#include "graph/dataflow/dump/graph_files.h"

namespace weft::graph::dataflow {
namespace {

using Value = Attribute::second_type;

const char* type_of(const Value& value) {
  return std::holds_alternative<std::int64_t>(value) ? "long"
         : std::holds_alternative<double>(value)     ? "double"
                                                     : "string";
}

void set_text(pugi::xml_node data, const Value& value) {
  if (const auto* n = std::get_if<std::int64_t>(&value))
    data.text().set(static_cast<long long>(*n));
  else if (const auto* x = std::get_if<double>(&value))
    data.text().set(engine::significant(*x, 17).c_str());  // pugixml would write it as the locale has it
  else
    data.text().set(std::get<std::string>(value).c_str());
}

/// Declares keys at their first use; all must come before the graph.
class Keys {
 public:
  Keys(pugi::xml_node root, const char* domain) : root_(root), domain_(domain) {}

  void declare(const std::string& name, const Value& value) {
    if (ids_.contains(name)) return;
    const std::string id = domain_ + std::to_string(ids_.size());
    pugi::xml_node key = root_.append_child("key");
    key.append_attribute("id") = id.c_str();
    key.append_attribute("for") = domain_.c_str();
    key.append_attribute("attr.name") = name.c_str();
    key.append_attribute("attr.type") = type_of(value);
    ids_[name] = id;
  }
  void put(pugi::xml_node element, const std::string& name, const Value& value) const {
    pugi::xml_node data = element.append_child("data");
    data.append_attribute("key") = ids_.at(name).c_str();
    set_text(data, value);
  }

 private:
  pugi::xml_node root_;
  std::string domain_;
  std::map<std::string, std::string> ids_;
};

std::vector<Attribute> all_of(const Drawing& drawing, const DrawnVertex& vertex) {
  std::string label;
  for (const std::string& line : vertex.label) label += (label.empty() ? "" : "\n") + line;
  std::vector<Attribute> all = {
      {"label", label},
      {"cluster", vertex.cluster ? drawing.clusters[*vertex.cluster] : std::string()},
      {"critical", std::int64_t{vertex.critical}}};
  all.insert(all.end(), vertex.attributes.begin(), vertex.attributes.end());
  return all;
}

std::vector<Attribute> all_of(const DrawnEdge& edge) {
  std::vector<Attribute> all = {{"label", edge.label},
                                {"edge_kind", std::string(name_of(edge.kind))},
                                {"critical", std::int64_t{edge.critical}}};
  all.insert(all.end(), edge.attributes.begin(), edge.attributes.end());
  return all;
}

}  // namespace

std::string graphml_of(const Drawing& drawing) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("graphml");
  root.append_attribute("xmlns") = "http://graphml.graphdrawing.org/xmlns";
  Keys vertex_keys(root, "node"), edge_keys(root, "edge");
  for (const DrawnVertex& vertex : drawing.vertices)
    for (const auto& [name, value] : all_of(drawing, vertex)) vertex_keys.declare(name, value);
  for (const DrawnEdge& edge : drawing.edges)
    for (const auto& [name, value] : all_of(edge)) edge_keys.declare(name, value);
  pugi::xml_node graph = root.append_child("graph");
  graph.append_attribute("id") = drawing.name.c_str();
  graph.append_attribute("edgedefault") = "directed";
  for (const DrawnVertex& vertex : drawing.vertices) {
    pugi::xml_node element = graph.append_child("node");
    element.append_attribute("id") = vertex.id.c_str();
    for (const auto& [name, value] : all_of(drawing, vertex)) vertex_keys.put(element, name, value);
  }
  for (const DrawnEdge& edge : drawing.edges) {
    pugi::xml_node element = graph.append_child("edge");
    element.append_attribute("source") = drawing.vertices[edge.from].id.c_str();
    element.append_attribute("target") = drawing.vertices[edge.to].id.c_str();
    for (const auto& [name, value] : all_of(edge)) edge_keys.put(element, name, value);
  }
  std::ostringstream out = engine::text_stream();
  document.save(out, " ", pugi::format_default, pugi::encoding_utf8);
  return out.str();
}

}  // namespace weft::graph::dataflow
