// A CAD model that can be asked for closest points: formulas where entities have them, else Newton's method
// from a guess, or from the best of samples.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/geometry/model/geometry_model.h"
#include "meshing/geometry/model/spline.h"

namespace weft::meshing {

/// Of the model's size: a vertex that is farther from its entity, and than the entity's tolerance, is off the
/// model.
inline constexpr double kOffModel = 1e-8;

/// A point of an edge.
struct OnEdge {
  Point x;
  double t = 0;
  Vec tangent;  ///< unit, along t; zero where the edge has none
  double distance = 0;
};

/// A point of a face.
struct OnFace {
  Point x;
  Parameters at{};
  Vec normal;  ///< unit, du x dv; zero where the face has none
  double distance = 0;
};

/// Principal curvatures and their directions, orthonormal with the normal. Positive: the surface bends
/// towards the normal.
struct SurfaceCurvature {
  double largest = 0, least = 0;
  Vec direction, across, normal;  ///< of `largest`, of `least`
};

/// Immutable; safe to ask from many threads. Coordinates are the model's times `scale`; parameters are its
/// own.
class Model {
 public:
  explicit Model(std::shared_ptr<const GeometryModel> geometry, double scale = 1);

  const GeometryModel& geometry() const { return *geometry_; }
  double scale() const { return scale_; }
  std::size_t num_nodes() const { return geometry_->nodes().size(); }
  std::size_t num_edges() const { return geometry_->edges().size(); }
  std::size_t num_faces() const { return geometry_->faces().size(); }
  const ModelEdge& edge(std::uint32_t e) const { return geometry_->edges()[e]; }
  const ModelFace& face(std::uint32_t f) const { return geometry_->faces()[f]; }
  Point node(std::uint32_t n) const { return scale_ * geometry_->nodes()[n].x; }
  double node_tolerance(std::uint32_t n) const { return scale_ * geometry_->nodes()[n].tolerance; }
  double edge_tolerance(std::uint32_t e) const { return scale_ * edge(e).tolerance; }
  double face_tolerance(std::uint32_t f) const { return scale_ * face(f).tolerance; }
  /// The faces that an edge borders, each once; the edges at a node.
  std::span<const std::uint32_t> faces_at_edge(std::uint32_t e) const { return edge_faces_[e]; }
  std::span<const std::uint32_t> edges_at_node(std::uint32_t n) const { return node_edges_[n]; }

  /// See GeometryModel::bodies_at.
  std::vector<std::uint32_t> bodies_at(std::span<const Point> points) const;

  const Box& box() const { return box_; }
  /// The diagonal of the box.
  double size() const { return size_; }
  const Box& edge_box(std::uint32_t e) const { return edge_boxes_[e]; }
  const Box& face_box(std::uint32_t f) const { return face_boxes_[f]; }
  /// How far triangles may be from a face, at its narrowest and where it curves most, and still have its
  /// shape: 0.1 % of the diagonal of its box, but at most 5 % of its least radius of curvature and, where
  /// that is below the diagonal, at least 1 %; at least 0.02 % of the diagonal.
  double detail(std::uint32_t f) const { return details_[f]; }
  /// Whether the closest point needs no guess.
  bool has_formula(std::uint32_t f) const { return face(f).form.kind != SurfaceForm::Kind::other; }
  /// Whether that holds of all faces.
  bool has_formulas() const;
  bool edge_has_formula(std::uint32_t e) const { return edge(e).form.kind != CurveForm::Kind::other; }
  /// The plane that a face lies in to 1e-11 of the model's size: a point and the unit normal du x dv.
  const std::optional<Frame>& plane(std::uint32_t f) const { return planes_[f]; }
  /// The line that an edge lies on likewise: a point and in `x` the direction along t.
  const std::optional<Frame>& line(std::uint32_t e) const { return lines_[e]; }

  CurveJet curve(std::uint32_t e, double t) const;
  SurfaceJet surface(std::uint32_t f, const Parameters& at) const;
  OnEdge point_on_edge(std::uint32_t e, double t) const;
  OnFace point_on_face(std::uint32_t f, const Parameters& at) const;
  /// None where the face has no normal.
  std::optional<SurfaceCurvature> curvature(std::uint32_t f, const Parameters& at) const;

  /// The closest point of an edge, within its range.
  OnEdge closest_on_edge(std::uint32_t e, const Point& p) const;
  OnEdge closest_on_edge(std::uint32_t e, const Point& p, double guess) const;
  /// The closest point of a face's surface, which may lie beyond the face's border.
  OnFace closest_on_face(std::uint32_t f, const Point& p) const;
  OnFace closest_on_face(std::uint32_t f, const Point& p, const Parameters& guess) const;
  /// The closest point within the face's border.
  OnFace closest_within(std::uint32_t f, const Point& p) const;
  /// Whether parameters lie within the border.
  bool is_inside(std::uint32_t f, Parameters at) const;
  /// `at` in the period that begins with the face's box; for closed edges with the edge's range.
  Parameters wrapped(std::uint32_t f, Parameters at) const;

 private:
  struct EdgeSamples {
    std::vector<double> t;
    std::vector<Point> x;
  };
  struct FaceSamples {
    std::array<int, 2> count{};
    std::vector<Parameters> at;
    std::vector<Point> x;
  };
  void take_splines();
  void sample_edges();
  void sample_faces();
  void connect();
  void trace_borders();
  void find_planes_and_lines();
  void find_details();
  double largest_curvature(std::uint32_t f) const;
  double in_range(std::uint32_t e, double t) const;
  bool newton(std::uint32_t e, const Point& p, double t, OnEdge& best) const;
  bool newton(std::uint32_t f, const Point& p, Parameters at, OnFace& best) const;
  bool leave_pole(std::uint32_t f, const Point& p, Parameters& at, double& value) const;
  OnFace on_face(std::uint32_t f, const SurfaceJet& jet, const Parameters& at) const;
  OnFace finish(std::uint32_t f, const Point& p, const Parameters& at) const;
  OnEdge finish(std::uint32_t e, const Point& p, double t) const;
  Parameters clamped(std::uint32_t f, Parameters at) const;

  std::shared_ptr<const GeometryModel> geometry_;
  std::vector<std::optional<SplineCurve>> spline_curves_;
  std::vector<std::optional<SplineSurface>> spline_surfaces_;
  double scale_ = 1, size_ = 0;
  Box box_;
  std::vector<std::vector<std::uint32_t>> edge_faces_, node_edges_;
  std::vector<EdgeSamples> edge_samples_;
  std::vector<FaceSamples> face_samples_;
  std::vector<Box> edge_boxes_, face_boxes_;
  /// Segments of each face's border in its parameters.
  std::vector<std::vector<std::array<Parameters, 2>>> borders_;
  std::vector<std::optional<Frame>> planes_, lines_;
  std::vector<double> details_;
};

}  // namespace weft::meshing
