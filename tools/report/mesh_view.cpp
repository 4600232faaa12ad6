#include "tools/report/mesh_view.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <unordered_map>

#include "meshing/measures.h"
#include "tools/picture/shown_faces.h"
#include "tools/report/base64.h"

namespace weft::report {
namespace {

using meshing::Box;
using meshing::LogMetric;
using meshing::MeshData;
using meshing::Point;
using Corner = std::array<float, 3>;

/// Values of tets, worked out where they are asked for.
class TetValues {
 public:
  TetValues(const MeshData& mesh, std::span<const LogMetric> log_metrics)
      : mesh_(mesh), log_metrics_(log_metrics) {}

  void fill(std::uint32_t tet, ViewFacet& facet) const {
    if (tet >= mesh_.tets.size()) return;
    std::array<Point, 4> points;
    std::array<LogMetric, 4> metrics;
    for (std::size_t i = 0; i < 4; ++i) {
      points[i] = mesh_.points[mesh_.tets[tet][i]];
      metrics[i] = log_metrics_[mesh_.tets[tet][i]];
    }
    facet.quality = static_cast<float>(meshing::mean_ratio(points, metrics));
    double off = 1;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) {
        const double length = meshing::edge_length(points[j] - points[i], meshing::exp_fast(metrics[i]),
                                                   meshing::exp_fast(metrics[j]));
        if (std::abs(std::log(length)) > std::abs(std::log(off))) off = length;
      }
    facet.length = static_cast<float>(off);
  }

 private:
  const MeshData& mesh_;
  std::span<const LogMetric> log_metrics_;
};

Corner corner_of(const Point& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

ViewLayer surface_layer(const MeshData& mesh, const TetValues& values, std::uint32_t subdomain,
                        bool is_piece) {
  ViewLayer layer;
  for (const picture::ShownFace& face : picture::Surface(mesh).faces()) {
    if (is_piece && !face.ref) continue;  // a face that another piece has too
    ViewFacet facet;
    for (std::size_t i = 0; i < 3; ++i) facet.corners[i] = corner_of(mesh.points[face.vertices[i]]);
    facet.subdomain = subdomain;
    values.fill(face.tet, facet);
    layer.facets.push_back(facet);
  }
  return layer;
}

void add_section(const MeshData& mesh, const picture::Section& section, ViewFacet facet, ViewLayer& layer) {
  std::array<Corner, 4> corners;
  for (int i = 0; i < section.size; ++i) {
    const auto& [from, to, share] = section.corners[static_cast<std::size_t>(i)];
    corners[static_cast<std::size_t>(i)] =
        corner_of(mesh.points[from] + share * (mesh.points[to] - mesh.points[from]));
  }
  for (std::size_t i = 2; i < static_cast<std::size_t>(section.size); ++i) {
    facet.corners = {corners[0], corners[i - 1], corners[i]};
    layer.facets.push_back(facet);
  }
}

ViewLayer section_layer(const MeshData& mesh, const TetValues& values, std::uint32_t subdomain, int axis,
                        double position) {
  ViewLayer layer{axis, position, {}, false};
  picture::Plane plane{{0, 0, 0}, position};
  plane.normal[axis] = 1;
  for (const picture::Section& section : picture::sections(mesh, plane)) {
    ViewFacet facet;
    facet.subdomain = subdomain;
    values.fill(section.tet, facet);
    add_section(mesh, section, facet, layer);
  }
  return layer;
}

// --- Thinning

float worse_length(float a, float b) { return std::abs(std::log(a)) >= std::abs(std::log(b)) ? a : b; }

/// Joins vertices in the cells of a grid; facets that collapse go, equal ones become one.
std::vector<ViewFacet> joined(const std::vector<ViewFacet>& facets, const Box& box, double cell) {
  using Cell = std::array<std::int32_t, 3>;
  std::map<Cell, std::uint32_t> number;
  std::vector<Corner> representative;
  const auto vertex = [&](const Corner& corner) {
    Cell at;
    for (int a = 0; a < 3; ++a)
      at[static_cast<std::size_t>(a)] =
          static_cast<std::int32_t>(std::floor((corner[static_cast<std::size_t>(a)] - box.lo[a]) / cell));
    const auto [found, is_new] = number.try_emplace(at, static_cast<std::uint32_t>(representative.size()));
    if (is_new) representative.push_back(corner);
    return found->second;
  };
  std::map<std::array<std::uint32_t, 3>, std::size_t> known;
  std::vector<ViewFacet> left;
  for (const ViewFacet& facet : facets) {
    std::array<std::uint32_t, 3> v = {vertex(facet.corners[0]), vertex(facet.corners[1]),
                                      vertex(facet.corners[2])};
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    std::array<std::uint32_t, 3> key = v;
    std::ranges::sort(key);
    const auto [found, is_new] = known.try_emplace(key, left.size());
    if (is_new) {
      left.push_back(facet);
      for (std::size_t i = 0; i < 3; ++i) left.back().corners[i] = representative[v[i]];
    } else {
      ViewFacet& other = left[found->second];
      other.quality = std::min(other.quality, facet.quality);
      other.length = worse_length(other.length, facet.length);
    }
  }
  return left;
}

void thin_out(ViewLayer& layer, const Box& box, std::size_t most) {
  const meshing::Vec size = box.size();
  const double largest = std::max({size.x, size.y, size.z});
  for (double cell = largest / 1024; layer.facets.size() > most; cell *= 1.3) {
    layer.facets = joined(layer.facets, box, cell);
    layer.thinned = true;
  }
}

// --- JSON

std::uint16_t sixteen_bits(double value, double lo, double hi) {
  const double share = hi > lo ? (value - lo) / (hi - lo) : 0;
  return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0, 1.0)));
}

/// log2 of a length from -4 to 4.
std::uint8_t length_code(float length) {
  return static_cast<std::uint8_t>(std::lround(255 * (std::clamp(std::log2(length), -4.0F, 4.0F) + 4) / 8));
}

bool is_unit(float length) {
  return length >= 1 / std::numbers::sqrt2_v<float> && length <= std::numbers::sqrt2_v<float>;
}

/// Vertices that facets share are written once.
nlohmann::ordered_json json_of(const ViewLayer& layer, const Box& box) {
  std::map<std::array<std::uint16_t, 3>, std::uint32_t> number;
  std::vector<std::uint16_t> positions, subdomains;
  std::vector<std::uint32_t> corners;
  std::vector<std::uint8_t> qualities, lengths, conforming;
  for (const ViewFacet& facet : layer.facets) {
    for (const Corner& corner : facet.corners) {
      std::array<std::uint16_t, 3> at;
      for (int a = 0; a < 3; ++a)
        at[static_cast<std::size_t>(a)] =
            sixteen_bits(corner[static_cast<std::size_t>(a)], box.lo[a], box.hi[a]);
      const auto [found, is_new] = number.try_emplace(at, static_cast<std::uint32_t>(number.size()));
      if (is_new) positions.insert(positions.end(), at.begin(), at.end());
      corners.push_back(found->second);
    }
    subdomains.push_back(static_cast<std::uint16_t>(facet.subdomain & 0xFFFF));
    qualities.push_back(static_cast<std::uint8_t>(std::lround(255 * std::clamp(facet.quality, 0.0F, 1.0F))));
    lengths.push_back(length_code(facet.length));
    conforming.push_back(is_unit(facet.length) ? 1 : 0);
  }
  return {{"axis", layer.axis},
          {"position", layer.position},
          {"thinned", layer.thinned},
          {"facets", layer.facets.size()},
          {"positions", base64_of(positions)},
          {"corners", base64_of(corners)},
          {"subdomain", base64_of(subdomains)},
          {"quality", base64_of(qualities)},
          {"length", base64_of(lengths)},
          {"conforming", base64_of(conforming)}};
}

}  // namespace

MeshView mesh_view(const MeshData& mesh, std::span<const LogMetric> log_metrics, std::uint32_t subdomain,
                   const Box& box, bool is_piece, const MeshViewOptions& options) {
  MeshView view;
  const TetValues values(mesh, log_metrics);
  view.layers.push_back(surface_layer(mesh, values, subdomain, is_piece));
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 1; i <= options.sections; ++i) {
      // Not at round shares of the box, where structured meshes have their faces.
      const double share = (i + 1e-3) / (options.sections + 1);
      view.layers.push_back(
          section_layer(mesh, values, subdomain, axis, box.lo[axis] + share * (box.hi[axis] - box.lo[axis])));
    }
  }
  return view;
}

void append(MeshView& view, MeshView&& part) {
  if (view.layers.empty()) {
    view = std::move(part);
    return;
  }
  for (std::size_t i = 0; i < view.layers.size(); ++i) {
    auto& facets = view.layers[i].facets;
    facets.insert(facets.end(), part.layers[i].facets.begin(), part.layers[i].facets.end());
    view.layers[i].thinned |= part.layers[i].thinned;
  }
}

void thin_out(MeshView& view, const Box& box, const MeshViewOptions& options) {
  for (ViewLayer& layer : view.layers)
    thin_out(layer, box, layer.axis < 0 ? options.surface_facets : options.section_facets);
}

nlohmann::ordered_json json_of(const MeshView& view, const Box& box) {
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  for (const ViewLayer& layer : view.layers) layers.push_back(json_of(layer, box));
  return {{"box", {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}}}, {"layers", layers}};
}

}  // namespace weft::report
