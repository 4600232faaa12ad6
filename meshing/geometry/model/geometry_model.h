// What a CAD model is to weft: faces, edges and nodes, what bounds what, and evaluation. Pure data and
// virtual functions, so that an implementation can be loaded at run time.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/geometry/model/closed_forms.h"

namespace weft::meshing {

inline constexpr std::uint32_t kNoEntity = 0xFFFFFFFFu;
inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

inline constexpr int kMostSplineDegree = 25;

/// One parameter of a spline, as plain data. Periodic splines are given unrolled.
struct SplineKnots {
  int degree = 0;             ///< 1 to kMostSplineDegree
  std::vector<double> knots;  ///< ascending, repeated by multiplicity: degree + 1 more than control points
};

/// A control point times its weight, and the weight.
using WeightedPoint = std::array<double, 4>;

struct CurveSpline {
  SplineKnots knots;
  std::vector<WeightedPoint> control;
};

struct SurfaceSpline {
  std::array<SplineKnots, 2> knots;    ///< in u and in v
  std::vector<WeightedPoint> control;  ///< those of one u together
};

struct ModelNode {
  Point x;
  double tolerance = 0;
};

struct ModelEdge {
  CurveForm form;
  double begin = 0, end = 0;  ///< range of the parameter, from nodes[0] to nodes[1]
  std::array<std::uint32_t, 2> nodes{kNoEntity, kNoEntity};  ///< equal for a closed edge
  double period = 0;                                         ///< of the parameter; 0: not periodic
  bool degenerate = false;                                   ///< a point of space, such as a pole
  double tolerance = 0;
  int spans = 1;                      ///< smooth pieces, to know how many samples it takes
  std::optional<CurveSpline> spline;  ///< what curve() evaluates, where it is one
};

/// An edge in the border of a face.
struct EdgeUse {
  std::uint32_t edge = kNoEntity;
  bool reversed = false;  ///< the border runs against the edge; tells the two uses of a seam apart
};

struct ModelFace {
  SurfaceForm form;
  Parameters lo{}, hi{};                                                     ///< box of the face's parameters
  Parameters first{-kUnbounded, -kUnbounded}, last{kUnbounded, kUnbounded};  ///< of the surface's
  Parameters period{};                                                       ///< 0: not periodic
  std::vector<EdgeUse> border;  ///< of all loops; empty for a closed surface without seams
  double tolerance = 0;
  bool reversed = false;                ///< the outward normal of the body is against du x dv
  std::array<int, 2> spans{1, 1};       ///< smooth pieces in u and v
  std::optional<SurfaceSpline> spline;  ///< what surface() evaluates, where it is one
};

/// Immutable; all functions may be called from many threads at once.
class GeometryModel {
 public:
  virtual ~GeometryModel() = default;
  virtual std::span<const ModelNode> nodes() const = 0;
  virtual std::span<const ModelEdge> edges() const = 0;
  virtual std::span<const ModelFace> faces() const = 0;
  /// Of any edge that is not degenerate, at any parameter of its range.
  virtual CurveJet curve(std::uint32_t edge, double t) const = 0;
  virtual SurfaceJet surface(std::uint32_t face, const Parameters& at) const = 0;
  /// Where on a face the edge is that borders it.
  virtual Parameters on_face(std::uint32_t face, const EdgeUse& use, double t) const = 0;

  /// Solid ones.
  virtual std::size_t num_bodies() const { return 0; }
  /// In which body each point lies, kNoEntity: in none. Points on a border are in none, too.
  virtual std::vector<std::uint32_t> bodies_at(std::span<const Point> points) const {
    return std::vector<std::uint32_t>(points.size(), kNoEntity);
  }

  virtual const std::string& name() const = 0;
  virtual const std::string& unit() const = 0;  ///< of length, such as "millimetre"; empty: not known
  virtual std::span<const std::string> warnings() const = 0;
};

}  // namespace weft::meshing
