// Sizes from the curvature of the boundary.
#include "meshing/metric/sources/curvature_metric.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/base/sort_unique.h"
#include "meshing/geometry/surface/surface.h"

namespace weft::meshing {
namespace {

struct Frame {
  Vec u, v, n;  ///< orthonormal, n the normal
};

Frame frame_of(const Vec& n) {
  const Vec axis = std::abs(n.x) < 0.6 ? Vec{1, 0, 0} : Vec{0, 1, 0};
  const Vec u = cross(n, axis);
  const Vec unit = (1 / norm(u)) * u;
  return {unit, cross(n, unit), n};
}

/// Curvature in the tangent plane: k(t) = a cos^2 + 2 b cos sin + c sin^2 for t at an angle to Frame::u.
struct ShapeOperator {
  double a = 0, b = 0, c = 0;
};

/// Fits a shape operator to the normal curvatures 2 n.d / |d|^2 along edges d, which a sphere's edges have
/// exactly.
class CurvatureFit {
 public:
  void add(const Frame& frame, const Vec& d) {
    const double x = dot(frame.u, d), y = dot(frame.v, d), r2 = x * x + y * y, d2 = norm2(d);
    if (!(r2 > 0)) return;
    const double curvature = 2 * dot(frame.n, d) / d2;
    const double row[3] = {x * x / r2, 2 * x * y / r2, y * y / r2};
    matrix_ = matrix_ + SymTensor{row[0] * row[0], row[0] * row[1], row[1] * row[1],
                                  row[0] * row[2], row[1] * row[2], row[2] * row[2]};
    right_ += curvature * Vec{row[0], row[1], row[2]};
  }
  /// The solution of least norm where the edges lie in fewer than three directions.
  ShapeOperator solve() const {
    const Eigen3 e = eigen_decomposition(matrix_);
    Vec solution;
    for (int i = 0; i < 3; ++i)
      if (e.values[i] > kLeastRatio * e.values[2])
        solution += (dot(e.vectors[i], right_) / e.values[i]) * e.vectors[i];
    return {solution.x, solution.y, solution.z};
  }

 private:
  static constexpr double kLeastRatio = 0.01;
  SymTensor matrix_;
  Vec right_;
};

class CurvatureSizes {
 public:
  CurvatureSizes(double largest, const CurvatureOptions& options) : options_(options), largest_(largest) {}

  double largest() const { return largest_; }

  Metric metric(const SurfaceCurvature& c) const {
    const double h1 = size(c.largest), h2 = size(c.least), hn = std::min(h1, h2);
    return from_eigen({{1 / (h1 * h1), 1 / (h2 * h2), 1 / (hn * hn)}, {c.direction, c.across, c.normal}});
  }

  Metric metric(const ShapeOperator& s, const Frame& frame) const {
    const double middle = 0.5 * (s.a + s.c), half = 0.5 * (s.a - s.c), radius = std::hypot(half, s.b);
    const double angle = 0.5 * std::atan2(s.b, half);
    const Vec along = std::cos(angle) * frame.u + std::sin(angle) * frame.v;
    const double h1 = size(middle + radius), h2 = size(middle - radius), hn = std::min(h1, h2);
    return from_eigen(
        {{1 / (h1 * h1), 1 / (h2 * h2), 1 / (hn * hn)}, {along, cross(frame.n, along), frame.n}});
  }

 private:
  double size(double curvature) const {
    double h = largest_;
    const double k = std::abs(curvature);
    if (k == 0) return h;
    if (options_.per_turn > 0) h = std::min(h, 2 * std::numbers::pi / (k * options_.per_turn));
    if (options_.sagitta > 0) h = std::min(h, std::sqrt(8 * options_.sagitta / k));
    return h;
  }

  CurvatureOptions options_;
  double largest_;
};

/// The least radius of a face that is believed. Towards a tip, where the face's parameters end in a point,
/// curvature may grow without end, and each mesh would ask for a finer one there.
double least_radius(const Model& model, std::uint32_t face) {
  constexpr double kTolerances = 100, kOfFaceAtTip = 1e-3;
  const ModelFace& f = model.face(face);
  const bool tip =
      f.form.kind == SurfaceForm::Kind::cone ||
      std::ranges::any_of(f.border, [&](const EdgeUse& u) { return model.edge(u.edge).degenerate; });
  const double least = tip ? kOfFaceAtTip * norm(model.face_box(face).size()) : 0;
  return std::max({least, kTolerances * model.face_tolerance(face), std::numeric_limits<double>::min()});
}

/// What is asked for at a vertex of a patch on the model; none where the model has no curvature there, but a
/// normal. A tip, which has neither, asks for nothing: its neighbours do, and gradation carries that to it.
std::optional<Metric> model_demand(const Surface& surface, PatchId patch, const CurvedVertex& vertex,
                                   const CurvatureSizes& sizes) {
  if (surface.faces(patch).empty()) return std::nullopt;
  const Model& model = *surface.model();
  const auto q = surface.closest_on_model(patch, vertex.x, vertex.kind, vertex.hint);
  std::optional<SurfaceCurvature> c = model.curvature(q.face, q.at.at);
  if (!c) {
    if (model.face(q.face).form.kind == SurfaceForm::Kind::cone || norm(q.at.normal) == 0)
      return identity_tensor(1 / (sizes.largest() * sizes.largest()));
    return std::nullopt;
  }
  const double most = 1 / least_radius(model, q.face);
  c->largest = std::clamp(c->largest, -most, most);
  c->least = std::clamp(c->least, -most, most);
  return sizes.metric(*c);
}

/// What the edges of one vertex, of one or more patches, ask for.
Metric demand(const Surface& surface, const std::vector<CurvedVertex>& vertices, const CurvatureSizes& sizes,
              std::span<const PatchEdge> edges) {
  const CurvedVertex& vertex = vertices[edges.front().vertex];
  Metric metric = identity_tensor(1 / (sizes.largest() * sizes.largest()));
  for (auto begin = edges.begin(); begin != edges.end();) {
    const std::uint32_t patch = begin->patch;
    const auto end = std::find_if(begin, edges.end(), [&](const PatchEdge& e) { return e.patch != patch; });
    if (const auto known = model_demand(surface, PatchId{patch}, vertex, sizes)) {
      metric = intersect(metric, *known);
      begin = end;
      continue;
    }
    const Frame frame =
        frame_of(surface.project_to_patch(PatchId{patch}, vertex.x, vertex.kind, vertex.hint).normal);
    CurvatureFit fit;
    for (; begin != end; ++begin) fit.add(frame, vertices[begin->other].x - vertex.x);
    metric = intersect(metric, sizes.metric(fit.solve(), frame));
  }
  return metric;
}

}  // namespace

void add_patch_edges(std::uint32_t vertex, PatchId patch, const std::array<std::uint32_t, 3>& triangle,
                     std::vector<PatchEdge>& edges) {
  for (const std::uint32_t other : triangle)
    if (other != vertex) edges.push_back({vertex, patch.value, other});
}

LogMetricField curvature_metric(const Surface& surface, const std::vector<CurvedVertex>& vertices,
                                std::vector<PatchEdge> edges, const CurvatureOptions& options,
                                double largest) {
  sort_unique(edges);
  std::vector<std::size_t> begins;  // of each vertex's edges
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (i == 0 || edges[i].vertex != edges[i - 1].vertex) begins.push_back(i);
  begins.push_back(edges.size());
  const CurvatureSizes sizes(largest, options);
  LogMetricField field(vertices.size(), identity_tensor(-2 * std::log(sizes.largest())));
  for_each_index(begins.size() - 1, [&](std::size_t i) {
    const std::span<const PatchEdge> at_vertex(&edges[begins[i]], begins[i + 1] - begins[i]);
    field[at_vertex.front().vertex] = log_of(demand(surface, vertices, sizes, at_vertex));
  });
  return field;
}

LogMetricField curvature_metric(const MeshData& mesh, const CurvatureOptions& options,
                                std::shared_ptr<const Model> model) {
  const Surface surface(mesh, {options.ridge_angle_degrees},
                        model ? classify_on_model(mesh, model) : ModelClassification{});
  std::vector<CurvedVertex> vertices;
  vertices.reserve(mesh.points.size());
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
    vertices.push_back({mesh.points[v], surface.vertex_kind(v), surface.vertex_hint(v)});
  std::vector<PatchEdge> edges;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const PatchId patch = surface.triangle_patch(t);
    if (!patch.valid() || surface.patches()[patch.value].planar) continue;
    for (const std::uint32_t v : mesh.triangles[t]) add_patch_edges(v, patch, mesh.triangles[t], edges);
  }
  return curvature_metric(surface, vertices, std::move(edges), options, largest_size(mesh));
}

}  // namespace weft::meshing
