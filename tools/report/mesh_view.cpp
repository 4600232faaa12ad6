#include "tools/report/mesh_view.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/json/json.h"
#include "meshing/base/parallel.h"
#include "meshing/geometry/model/face_deviations.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/metric/measures.h"
#include "tools/picture/shown_faces.h"
#include "tools/report/cut_tets.h"
#include "tools/report/encode/base64.h"
#include "tools/report/flat_index.h"

namespace weft::report {
namespace {

using meshing::Box;
using meshing::LogMetric;
using meshing::MeshData;
using meshing::Point;

/// How far a length is from 1, by ratio.
float off_unit(float length) { return std::max(length, 1 / length); }

float worse_length(float a, float b) { return off_unit(a) >= off_unit(b) ? a : b; }

Corner corner_of(const Point& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

constexpr std::uint32_t kAbsent = meshing::kNoNeighbour;

/// Where a facet comes from.
struct Origin {
  std::uint32_t piece;
  std::uint32_t tet;                 ///< kAbsent: a triangle without
  std::uint32_t triangle = kAbsent;  ///< of the surface; kAbsent in a section
};

/// A layer before it is thinned out.
struct WholeLayer {
  Triangles triangles;
  std::vector<Origin> origins;  ///< of each triangle
};

/// Quality and length of a tet in its metric.
void put_values(const ViewedPiece& piece, const meshing::Tet& tet, ViewFacet& facet) {
  std::array<Point, 4> points;
  std::array<LogMetric, 4> log_metrics;
  std::array<meshing::Metric, 4> metrics;
  for (std::size_t i = 0; i < 4; ++i) {
    points[i] = piece.mesh.points[tet[i]];
    log_metrics[i] = piece.log_metrics[tet[i]];
    metrics[i] = meshing::exp_fast(log_metrics[i]);
  }
  facet.quality = static_cast<float>(meshing::mean_ratio(points, log_metrics));
  facet.length = 1;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double length = meshing::edge_length(points[j] - points[i], metrics[i], metrics[j]);
      facet.length = worse_length(facet.length, static_cast<float>(length));
    }
}

void put_worse(const ViewFacet& other, ViewFacet& facet) {
  facet.quality = std::min(facet.quality, other.quality);
  facet.length = worse_length(facet.length, other.length);
  facet.deviation = std::max(facet.deviation, other.deviation);
}

/// The facets that are left, each with the worst values of those that it stands for: `kept[i]` is the facet
/// thinning.kept[i] was.
std::vector<ViewFacet> merged(const Thinning& thinning, const std::vector<ViewFacet>& kept) {
  std::vector<ViewFacet> facets;
  facets.reserve(thinning.left.corners.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const std::uint32_t place = thinning.in_left[i];
    if (place < facets.size()) {
      put_worse(kept[i], facets[place]);
    } else {
      facets.push_back(kept[i]);
      facets.back().corners = thinning.left.at(place);
    }
  }
  return facets;
}

/// Corners are shared by the two triangles of a quadrilateral only: joining them finds the others.
void add_section(const MeshData& mesh, const picture::Section& section, const Origin& origin,
                 WholeLayer& layer) {
  const auto first = static_cast<std::uint32_t>(layer.triangles.points.size());
  const auto size = static_cast<std::uint32_t>(section.size);
  for (std::uint32_t i = 0; i < size; ++i) {
    const auto& [from, to, share] = section.corners[i];
    layer.triangles.points.push_back(
        corner_of(mesh.points[from] + share * (mesh.points[to] - mesh.points[from])));
  }
  for (std::uint32_t i = 2; i < size; ++i) {
    layer.triangles.corners.push_back({first, first + i - 1, first + i});
    layer.origins.push_back(origin);
  }
}

/// Planes at equal distances: not at round shares of the box, where structured meshes have their faces.
AxisPlanes planes_across(const Box& box, int sections) {
  AxisPlanes planes;
  for (int axis = 0; axis < 3; ++axis) {
    const double distance = (box.hi[axis] - box.lo[axis]) / (sections + 1);
    for (int i = 0; i < sections; ++i)
      planes[static_cast<std::size_t>(axis)].push_back(box.lo[axis] + (i + 1 + 1e-3) * distance);
  }
  return planes;
}

/// Makes the layers of a view, each on its own.
class LayerMaker {
 public:
  LayerMaker(std::span<const ViewedPiece> pieces, const AxisPlanes& planes, const meshing::Model* model)
      : pieces_(pieces) {
    for (const ViewedPiece& piece : pieces) {
      const MeshData& mesh = piece.mesh;
      codes_.push_back(meshing::match_triangles(mesh.triangles, mesh.tets, mesh.points.size()));
      cut_.push_back(cut_tets(mesh, planes));
      if (model) deviations_.emplace_back(mesh, *model);
    }
  }

  WholeLayer surface() const {
    WholeLayer layer;
    auto& [points, corners] = layer.triangles;
    for (std::uint32_t p = 0; p < pieces_.size(); ++p) {
      const MeshData& mesh = pieces_[p].mesh;
      std::vector<std::uint32_t> place(mesh.points.size(), kAbsent);  // in `points`
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        corners.push_back(mesh.triangles[t]);
        for (std::uint32_t& v : corners.back()) {
          if (place[v] == kAbsent) {
            place[v] = static_cast<std::uint32_t>(points.size());
            points.push_back(corner_of(mesh.points[v]));
          }
          v = place[v];
        }
        const std::uint32_t code = codes_[p][t];
        layer.origins.push_back({p, code == kAbsent ? kAbsent : code / 4, t});
      }
    }
    return layer;
  }

  /// `number`: of the plane in the order of cut_tets().
  WholeLayer section(std::size_t number, int axis, double position) const {
    picture::Plane plane{{0, 0, 0}, position};
    plane.normal[axis] = 1;
    WholeLayer layer;
    for (std::uint32_t p = 0; p < pieces_.size(); ++p)
      for (const std::uint32_t tet : cut_[p][number])
        if (const auto section = picture::section(pieces_[p].mesh, tet, plane))
          add_section(pieces_[p].mesh, *section, {p, tet}, layer);
    return layer;
  }

  /// With all but the corners.
  ViewFacet facet(const Origin& origin) const {
    const ViewedPiece& piece = pieces_[origin.piece];
    ViewFacet facet;
    facet.subdomain = piece.subdomain;
    if (origin.tet != kAbsent) put_values(piece, piece.mesh.tets[origin.tet], facet);
    if (origin.triangle != kAbsent && !deviations_.empty()) {
      const double d = deviations_[origin.piece].at(piece.mesh.triangles[origin.triangle]);
      if (d >= 0) facet.deviation = static_cast<float>(d);
    }
    return facet;
  }

 private:
  std::span<const ViewedPiece> pieces_;
  std::vector<std::vector<std::uint32_t>> codes_;             // of the pieces' triangles
  std::vector<std::vector<std::vector<std::uint32_t>>> cut_;  // of the pieces, by plane
  std::vector<meshing::FaceDeviations> deviations_;           // of the pieces, where there is a model
};

Triangles triangles_of(const std::vector<ViewFacet>& facets) {
  Triangles triangles;
  for (const ViewFacet& facet : facets) triangles.add(facet.corners);
  return triangles;
}

std::size_t most_facets(const ViewLayer& layer, const MeshViewOptions& options) {
  return layer.axis < 0 ? options.surface_facets : options.section_facets;
}

/// Layers are independent of each other; the largest take longest.
template <class Visit>
void for_each_layer(std::size_t n, const Visit& visit) {
  tbb::parallel_for(std::size_t{0}, n, visit);
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

/// 255: there is none.
std::uint8_t deviation_code(float deviation, float largest) {
  if (deviation < 0) return 255;
  return static_cast<std::uint8_t>(std::lround(254 * (largest > 0 ? deviation / largest : 0.0F)));
}

/// Vertices that facets share are written once.
nlohmann::ordered_json json_of(const ViewLayer& layer, const Box& box, float largest_deviation) {
  FlatIndex<std::uint16_t, 3> numbers(layer.facets.size());
  std::vector<std::uint16_t> positions, subdomains;
  std::vector<std::uint32_t> corners;
  std::vector<std::uint8_t> qualities, lengths, conforming, deviations;
  for (const ViewFacet& facet : layer.facets) {
    for (const Corner& corner : facet.corners) {
      std::array<std::uint16_t, 3> at;
      for (int a = 0; a < 3; ++a)
        at[static_cast<std::size_t>(a)] =
            sixteen_bits(corner[static_cast<std::size_t>(a)], box.lo[a], box.hi[a]);
      const std::size_t known = numbers.size();
      corners.push_back(numbers.number_of(at));
      if (numbers.size() > known) positions.insert(positions.end(), at.begin(), at.end());
    }
    subdomains.push_back(static_cast<std::uint16_t>(facet.subdomain & 0xFFFF));
    qualities.push_back(static_cast<std::uint8_t>(std::lround(255 * std::clamp(facet.quality, 0.0F, 1.0F))));
    lengths.push_back(length_code(facet.length));
    conforming.push_back(is_unit(facet.length) ? 1 : 0);
    deviations.push_back(deviation_code(facet.deviation, largest_deviation));
  }
  nlohmann::ordered_json json = {{"axis", layer.axis},
                                 {"position", layer.position},
                                 {"thinned", layer.thinned},
                                 {"facets", layer.facets.size()},
                                 {"positions", base64_of(positions)},
                                 {"corners", base64_of(corners)},
                                 {"subdomain", base64_of(subdomains)},
                                 {"quality", base64_of(qualities)},
                                 {"length", base64_of(lengths)},
                                 {"conforming", base64_of(conforming)}};
  if (layer.axis < 0 && largest_deviation >= 0) json["deviation"] = base64_of(deviations);
  return json;
}

}  // namespace

MeshView mesh_view(std::span<const ViewedPiece> pieces, const Box& box, const MeshViewOptions& options,
                   const meshing::Model* model) {
  const AxisPlanes planes = planes_across(box, options.sections);
  const LayerMaker maker(pieces, planes, model);
  MeshView view;
  view.layers.push_back({});
  for (int axis = 0; axis < 3; ++axis)
    for (const double position : planes[static_cast<std::size_t>(axis)])
      view.layers.push_back({axis, position, {}, false});
  for_each_layer(view.layers.size(), [&](std::size_t l) {
    ViewLayer& layer = view.layers[l];
    WholeLayer whole = l == 0 ? maker.surface() : maker.section(l - 1, layer.axis, layer.position);
    const Thinning thinning = thinned_out(std::move(whole.triangles), box, most_facets(layer, options));
    std::vector<ViewFacet> kept(thinning.kept.size());
    meshing::for_each_index(kept.size(),
                            [&](std::size_t i) { kept[i] = maker.facet(whole.origins[thinning.kept[i]]); });
    layer.facets = merged(thinning, kept);
    layer.thinned = thinning.thinned;
  });
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
  for_each_layer(view.layers.size(), [&](std::size_t l) {
    ViewLayer& layer = view.layers[l];
    if (layer.facets.size() <= most_facets(layer, options)) return;
    const Thinning thinning = thinned_out(triangles_of(layer.facets), box, most_facets(layer, options));
    std::vector<ViewFacet> kept;
    kept.reserve(thinning.kept.size());
    for (const std::uint32_t f : thinning.kept) kept.push_back(layer.facets[f]);
    layer.facets = merged(thinning, kept);
    layer.thinned = true;
  });
}

nlohmann::ordered_json json_of(const MeshView& view, const Box& box) {
  float largest = kNoDeviation;
  for (const ViewLayer& layer : view.layers)
    if (layer.axis < 0)
      for (const ViewFacet& facet : layer.facets) largest = std::max(largest, facet.deviation);
  std::vector<nlohmann::ordered_json> layers(view.layers.size());
  for_each_layer(layers.size(), [&](std::size_t l) { layers[l] = json_of(view.layers[l], box, largest); });
  nlohmann::ordered_json json = {{"box", {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}}},
                                 {"layers", layers}};
  json["largest_deviation"] = largest >= 0 ? nlohmann::ordered_json(largest) : nlohmann::ordered_json();
  return json;
}

}  // namespace weft::report
