// The account of a mesh on a CAD model.
#include "tools/library/report/model_text.h"

#include <fmt/format.h>

#include <array>

#include "engine/json/json.h"
#include "tools/common/text.h"

namespace weft::tools {
namespace {

using meshing::ModelAccount;
using meshing::ModelEntityAccount;

constexpr std::array<const char*, 3> kKinds = {"node", "edge", "face"};

const char* kind(const ModelEntityAccount& entity) { return kKinds[static_cast<std::size_t>(entity.kind)]; }

std::string table(const ModelAccount& account) {
  std::string text = fmt::format("  {:<14}{:>10}{:>12}{:>12}{:>12}{:>12}{:>9}\n", "entity", "vertices",
                                 "largest", "mean", "deviation", "tolerance", "normal");
  for (const ModelEntityAccount& e : account.entities) {
    text +=
        fmt::format("  {:<14}{:>10}{:>12.3g}{:>12.3g}{:>12.3g}{:>12.3g}", fmt::format("{} {}", kind(e), e.id),
                    grouped(e.vertices), e.largest, e.mean, e.deviation, e.tolerance);
    text += e.kind == ModelEntityAccount::Kind::face ? fmt::format("{:>9.3f}\n", e.least_normal) : "\n";
  }
  return text;
}

}  // namespace

std::string model_text(const ModelAccount& a, bool entities) {
  std::string text = fmt::format("model {}: {} faces, {} edges, {} nodes, size {:.6g}{}{}\n", a.model,
                                 a.faces, a.edges, a.nodes, a.size, a.unit.empty() ? "" : " " + a.unit,
                                 a.scale == 1 ? "" : fmt::format(" (scaled by {:.6g})", a.scale));
  text += fmt::format(
      "  {} boundary vertices on it: largest distance {:.3g}, mean {:.3g}; {} off it (beyond {:.3g})\n",
      grouped(a.vertices), a.largest, a.mean, grouped(a.off), a.tolerance);
  text += fmt::format("  {} triangles on it: deviation at most {:.3g}, least product of normals {:.3f}\n",
                      grouped(a.triangles), a.deviation, a.least_normal);
  if (a.turned > 0) text += fmt::format("  {} triangles turned against it\n", grouped(a.turned));
  if (a.unclassified_triangles > 0)
    text += fmt::format("  {} triangles on no face of it\n", grouped(a.unclassified_triangles));
  if (!a.listed.empty()) {
    text += "  vertices off the model:";
    for (std::size_t i = 0; i < std::min<std::size_t>(a.listed.size(), 10); ++i)
      text += fmt::format(" {}", a.listed[i] + 1);
    text += a.listed.size() > 10 ? " ...\n" : "\n";
  }
  return entities ? text + table(a) : text;
}

nlohmann::ordered_json json_of(const ModelAccount& a) {
  nlohmann::ordered_json entities = nlohmann::ordered_json::array();
  for (const ModelEntityAccount& e : a.entities)
    entities.push_back({{"kind", kind(e)},
                        {"id", e.id},
                        {"vertices", e.vertices},
                        {"largest", e.largest},
                        {"mean", e.mean},
                        {"deviation", e.deviation},
                        {"tolerance", e.tolerance},
                        {"least_normal", e.least_normal},
                        {"turned", e.turned}});
  std::vector<std::uint32_t> listed;
  for (const std::uint32_t v : a.listed) listed.push_back(v + 1);
  return {{"model", a.model},
          {"unit", a.unit},
          {"scale", a.scale},
          {"size", a.size},
          {"nodes", a.nodes},
          {"edges", a.edges},
          {"faces", a.faces},
          {"vertices", a.vertices},
          {"triangles", a.triangles},
          {"unclassified_triangles", a.unclassified_triangles},
          {"off", a.off},
          {"listed", listed},
          {"largest", a.largest},
          {"mean", a.mean},
          {"deviation", a.deviation},
          {"least_normal", a.least_normal},
          {"turned", a.turned},
          {"input", {{"off", a.input.off}, {"largest", a.input.largest}, {"turned", a.input.turned}}},
          {"tolerance", a.tolerance},
          {"entities", std::move(entities)}};
}

}  // namespace weft::tools
