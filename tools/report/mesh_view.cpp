#include "tools/report/mesh_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "engine/json/json.h"
#include "meshing/geometry/model/face_deviations.h"
#include "meshing/metric/measures.h"
#include "tools/picture/shown_faces.h"
#include "tools/report/encode/base64.h"
#include "tools/report/flat_index.h"

namespace weft::report {
namespace {

using meshing::Box;
using meshing::LogMetric;
using meshing::MeshData;
using meshing::Point;
using Corner = std::array<float, 3>;

/// How far a length is from 1, by ratio.
float off_unit(float length) { return std::max(length, 1 / length); }

float worse_length(float a, float b) { return off_unit(a) >= off_unit(b) ? a : b; }

/// Values of tets, worked out where they are asked for.
class TetValues {
 public:
  TetValues(const MeshData& mesh, std::span<const LogMetric> log_metrics)
      : mesh_(mesh), log_metrics_(log_metrics), numbers_(mesh.points.size() / 8) {}

  void fill(std::uint32_t tet, ViewFacet& facet) {
    if (tet >= mesh_.tets.size()) return;
    std::array<Point, 4> points;
    std::array<LogMetric, 4> log_metrics;
    std::array<meshing::Metric, 4> metrics;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t vertex = mesh_.tets[tet][i];
      points[i] = mesh_.points[vertex];
      log_metrics[i] = log_metrics_[vertex];
      metrics[i] = metric_at(vertex);
    }
    facet.quality = static_cast<float>(meshing::mean_ratio(points, log_metrics));
    facet.length = 1;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) {
        const double length = meshing::edge_length(points[j] - points[i], metrics[i], metrics[j]);
        facet.length = worse_length(facet.length, static_cast<float>(length));
      }
  }

 private:
  /// Kept: a vertex is asked for by several tets, and an exponential costs as much as all the rest.
  const meshing::Metric& metric_at(std::uint32_t vertex) {
    const std::uint32_t number = numbers_.number_of({vertex});
    if (number == metrics_.size()) metrics_.push_back(meshing::exp_fast(log_metrics_[vertex]));
    return metrics_[number];
  }

  const MeshData& mesh_;
  std::span<const LogMetric> log_metrics_;
  FlatIndex<std::uint32_t, 1> numbers_;  // of vertices in metrics_
  std::vector<meshing::Metric> metrics_;
};

Corner corner_of(const Point& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

ViewLayer surface_layer(const MeshData& mesh, TetValues& values, std::uint32_t subdomain, bool is_piece,
                        const meshing::Model* model) {
  ViewLayer layer;
  std::optional<meshing::FaceDeviations> deviations;
  if (model) deviations.emplace(mesh, *model);
  for (const picture::ShownFace& face : picture::Surface(mesh).faces()) {
    if (is_piece && !face.ref) continue;  // a face that another piece has too
    ViewFacet facet;
    for (std::size_t i = 0; i < 3; ++i) facet.corners[i] = corner_of(mesh.points[face.vertices[i]]);
    facet.subdomain = subdomain;
    values.fill(face.tet, facet);
    if (deviations)
      if (const double d = deviations->at(face.vertices); d >= 0) facet.deviation = static_cast<float>(d);
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

/// Planes across one axis, at equal distances.
struct Planes {
  double lo, distance;
  int count;

  Planes(const Box& box, int axis, int planes)
      : lo(box.lo[axis]), distance((box.hi[axis] - box.lo[axis]) / (planes + 1)), count(planes) {}

  /// Of plane `i`, from 0: not at round shares of the box, where structured meshes have their faces.
  double position(int i) const { return lo + (i + 1 + 1e-3) * distance; }
  /// The first plane that is not before x.
  int first_from(double x) const {
    if (!(distance > 0)) return count;
    int i = static_cast<int>(std::clamp((x - lo) / distance - 2, 0.0, 1.0 * count));  // before it
    while (i < count && position(i) < x) ++i;
    return i;
  }
};

/// Adds the sections of one tet by the planes across an axis to `layers`, one layer a plane.
void add_sections(const MeshData& mesh, TetValues& values, std::uint32_t tet, std::uint32_t subdomain,
                  int axis, const Planes& planes, std::span<ViewLayer> layers) {
  double lo = mesh.points[mesh.tets[tet][0]][axis], hi = lo;
  for (const std::uint32_t v : mesh.tets[tet]) {
    lo = std::min(lo, mesh.points[v][axis]);
    hi = std::max(hi, mesh.points[v][axis]);
  }
  for (int i = planes.first_from(lo); i < planes.count && planes.position(i) < hi; ++i) {
    picture::Plane plane{{0, 0, 0}, planes.position(i)};
    plane.normal[axis] = 1;
    const auto section = picture::section(mesh, tet, plane);
    if (!section) continue;
    ViewFacet facet;
    facet.subdomain = subdomain;
    values.fill(tet, facet);
    add_section(mesh, *section, facet, layers[static_cast<std::size_t>(i)]);
  }
}

// --- Thinning

/// The cells of a grid as vertices: the first point met in a cell stands for all of it.
class GridVertices {
 public:
  GridVertices(const Box& box, double cell, std::size_t expected)
      : box_(box), cells_in_one_(1 / cell), numbers_(expected) {}

  std::uint32_t number_of(const Corner& corner) {
    std::array<std::int32_t, 3> cell;
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      cell[i] = static_cast<std::int32_t>(std::floor((corner[i] - box_.lo[a]) * cells_in_one_));
    }
    const std::uint32_t number = numbers_.number_of(cell);
    if (number == points_.size()) points_.push_back(corner);
    return number;
  }
  const Corner& point(std::uint32_t number) const { return points_[number]; }

 private:
  const Box& box_;
  double cells_in_one_;
  FlatIndex<std::int32_t, 3> numbers_;
  std::vector<Corner> points_;
};

/// Joins vertices in the cells of a grid; facets that collapse go, equal ones become one.
std::vector<ViewFacet> joined(const std::vector<ViewFacet>& facets, const Box& box, double cell) {
  GridVertices vertices(box, cell, facets.size());
  FlatIndex<std::uint32_t, 3> known(facets.size());
  std::vector<ViewFacet> left;
  for (const ViewFacet& facet : facets) {
    std::array<std::uint32_t, 3> v;
    for (std::size_t i = 0; i < 3; ++i) v[i] = vertices.number_of(facet.corners[i]);
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    std::array<std::uint32_t, 3> key = v;
    std::ranges::sort(key);
    const std::uint32_t number = known.number_of(key);
    if (number == left.size()) {
      left.push_back(facet);
      for (std::size_t i = 0; i < 3; ++i) left.back().corners[i] = vertices.point(v[i]);
    } else {
      ViewFacet& other = left[number];
      other.quality = std::min(other.quality, facet.quality);
      other.length = worse_length(other.length, facet.length);
      other.deviation = std::max(other.deviation, facet.deviation);
    }
  }
  return left;
}

/// On a surface the number of facets goes at most with the square of the cells' size, once these are larger
/// than the facets: the step to the next grid is as large as that allows.
void thin_out(ViewLayer& layer, const Box& box, std::size_t most) {
  constexpr double kLeastStep = 1.1;
  const meshing::Vec size = box.size();
  double cell = std::max({size.x, size.y, size.z}) / 1024;
  while (layer.facets.size() > most) {
    layer.facets = joined(layer.facets, box, cell);
    layer.thinned = true;
    const double excess = static_cast<double>(layer.facets.size()) / static_cast<double>(most);
    cell *= std::max(kLeastStep, std::sqrt(excess));
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

MeshView mesh_view(const MeshData& mesh, std::span<const LogMetric> log_metrics, std::uint32_t subdomain,
                   const Box& box, bool is_piece, const MeshViewOptions& options,
                   const meshing::Model* model) {
  MeshView view;
  TetValues values(mesh, log_metrics);
  view.layers.push_back(surface_layer(mesh, values, subdomain, is_piece, model));
  for (int axis = 0; axis < 3; ++axis) {
    const Planes planes(box, axis, options.sections);
    const std::size_t first = view.layers.size();
    for (int i = 0; i < planes.count; ++i) view.layers.push_back({axis, planes.position(i), {}, false});
    const std::span<ViewLayer> mine = std::span(view.layers).subspan(first);
    for (std::uint32_t tet = 0; tet < mesh.tets.size(); ++tet)
      add_sections(mesh, values, tet, subdomain, axis, planes, mine);
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
  float largest = kNoDeviation;
  for (const ViewLayer& layer : view.layers)
    if (layer.axis < 0)
      for (const ViewFacet& facet : layer.facets) largest = std::max(largest, facet.deviation);
  for (const ViewLayer& layer : view.layers) layers.push_back(json_of(layer, box, largest));
  nlohmann::ordered_json json = {{"box", {{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}}},
                                 {"layers", layers}};
  json["largest_deviation"] = largest >= 0 ? nlohmann::ordered_json(largest) : nlohmann::ordered_json();
  return json;
}

}  // namespace weft::report
