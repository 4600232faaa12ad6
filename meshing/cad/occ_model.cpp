// From OpenCASCADE's topology to plain faces, edges and nodes.
#include "meshing/cad/occ_model.h"

#include <BRepBndLib.hxx>
#include <BRepClass3d_SolidClassifier.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Precision.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/error.h"

namespace weft::meshing {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

Point point(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }
Vec vec(const gp_Vec& v) { return {v.X(), v.Y(), v.Z()}; }
Vec vec(const gp_Dir& v) { return {v.X(), v.Y(), v.Z()}; }

Frame frame(const gp_Ax2& a) {
  return {point(a.Location()), vec(a.XDirection()), vec(a.YDirection()), vec(a.Direction())};
}
Frame frame(const gp_Ax3& a) {
  return {point(a.Location()), vec(a.XDirection()), vec(a.YDirection()), vec(a.Direction())};
}

CurveForm form_of(const Handle(Geom_Curve) & curve) {
  const GeomAdaptor_Curve adaptor(curve);
  CurveForm form;
  if (adaptor.GetType() == GeomAbs_Line) {
    const gp_Lin line = adaptor.Line();
    form.kind = CurveForm::Kind::line;
    form.frame.origin = point(line.Location());
    form.frame.x = vec(line.Direction());
  } else if (adaptor.GetType() == GeomAbs_Circle) {
    form.kind = CurveForm::Kind::circle;
    form.frame = frame(adaptor.Circle().Position());
    form.radius = adaptor.Circle().Radius();
  }
  return form;
}

SurfaceForm form_of(const Handle(Geom_Surface) & surface, const ModelFace& face) {
  using Kind = SurfaceForm::Kind;
  const GeomAdaptor_Surface a(surface);
  switch (a.GetType()) {
    case GeomAbs_Plane:
      return {Kind::plane, frame(a.Plane().Position())};
    case GeomAbs_Cylinder:
      return {Kind::cylinder, frame(a.Cylinder().Position()), a.Cylinder().Radius()};
    case GeomAbs_Cone: {
      const gp_Cone cone = a.Cone();
      const double middle = 0.5 * (face.lo[1] + face.hi[1]);
      const bool beyond = cone.RefRadius() + middle * std::sin(cone.SemiAngle()) < 0;
      return {Kind::cone, frame(cone.Position()), cone.RefRadius(), cone.SemiAngle(), beyond};
    }
    case GeomAbs_Sphere:
      return {Kind::sphere, frame(a.Sphere().Position()), a.Sphere().Radius()};
    case GeomAbs_Torus: {
      const gp_Torus torus = a.Torus();
      // A torus that meets itself has points whose closest one is not that of the formula.
      if (torus.MinorRadius() >= torus.MajorRadius()) return {};
      return {Kind::torus, frame(torus.Position()), torus.MajorRadius(), torus.MinorRadius()};
    }
    default:
      return {};
  }
}

int spans_of(const Handle(Geom_Curve) & curve) {
  const GeomAdaptor_Curve adaptor(curve);
  return std::max(1, adaptor.NbIntervals(GeomAbs_C2)) *
         std::clamp(adaptor.GetType() == GeomAbs_BezierCurve ? adaptor.Degree() : 1, 1, 8);
}

SplineKnots knots_of(int degree, const TColStd_Array1OfReal& knots) {
  return {degree, {knots.begin(), knots.end()}};
}

WeightedPoint weighted(const gp_Pnt& p, double weight) {
  return {weight * p.X(), weight * p.Y(), weight * p.Z(), weight};
}

/// Splines as plain data, periodic ones unrolled: weft evaluates them many times faster.
std::optional<CurveSpline> spline_of(const Handle(Geom_Curve) & curve) {
  if (!curve->IsKind(STANDARD_TYPE(Geom_BSplineCurve)) && !curve->IsKind(STANDARD_TYPE(Geom_BezierCurve)))
    return std::nullopt;
  const auto spline = Handle(Geom_BSplineCurve)::DownCast(GeomConvert::CurveToBSplineCurve(curve)->Copy());
  if (spline->IsPeriodic()) spline->SetNotPeriodic();
  CurveSpline result;
  result.knots = knots_of(spline->Degree(), spline->KnotSequence());
  const bool rational = spline->IsRational();
  for (int i = 1; i <= spline->NbPoles(); ++i)
    result.control.push_back(weighted(spline->Pole(i), rational ? spline->Weight(i) : 1));
  return result;
}

std::optional<SurfaceSpline> spline_of(const Handle(Geom_Surface) & surface) {
  if (!surface->IsKind(STANDARD_TYPE(Geom_BSplineSurface)) &&
      !surface->IsKind(STANDARD_TYPE(Geom_BezierSurface)))
    return std::nullopt;
  const auto spline =
      Handle(Geom_BSplineSurface)::DownCast(GeomConvert::SurfaceToBSplineSurface(surface)->Copy());
  if (spline->IsUPeriodic()) spline->SetUNotPeriodic();
  if (spline->IsVPeriodic()) spline->SetVNotPeriodic();
  SurfaceSpline result;
  result.knots = {knots_of(spline->UDegree(), spline->UKnotSequence()),
                  knots_of(spline->VDegree(), spline->VKnotSequence())};
  // Unrolled, a surface that is not rational has weights of 0.
  const bool rational = spline->IsURational() || spline->IsVRational();
  for (int i = 1; i <= spline->NbUPoles(); ++i)
    for (int j = 1; j <= spline->NbVPoles(); ++j)
      result.control.push_back(weighted(spline->Pole(i, j), rational ? spline->Weight(i, j) : 1));
  return result;
}

/// Untrimmed: formulas and ranges are those of the surface below.
Handle(Geom_Surface) basis_of(Handle(Geom_Surface) surface) {
  while (!surface.IsNull() && surface->IsKind(STANDARD_TYPE(Geom_RectangularTrimmedSurface)))
    surface = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface)->BasisSurface();
  return surface;
}

Handle(Geom_Curve) basis_of(Handle(Geom_Curve) curve) {
  while (!curve.IsNull() && curve->IsKind(STANDARD_TYPE(Geom_TrimmedCurve)))
    curve = Handle(Geom_TrimmedCurve)::DownCast(curve)->BasisCurve();
  return curve;
}

double bounded(double x) { return std::abs(x) > 1e99 ? std::copysign(kUnbounded, x) : x; }

double into_range(double x, double first, double period) {
  return x - period * std::floor((x - first) / period);
}

/// Which points lie in a solid. One whose faces look inwards has the infinite within it: what is meant is
/// what it encloses.
std::vector<std::size_t> points_in(const TopoDS_Shape& solid, std::span<const Point> points) {
  Bnd_Box box;
  BRepBndLib::Add(solid, box);
  BRepClass3d_SolidClassifier place(solid);
  place.PerformInfinitePoint(Precision::Confusion());
  const TopAbs_State within = place.State() == TopAbs_IN ? TopAbs_OUT : TopAbs_IN;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const gp_Pnt p(points[i].x, points[i].y, points[i].z);
    if (box.IsOut(p)) continue;
    place.Perform(p, Precision::Confusion());
    if (place.State() == within) found.push_back(i);
  }
  return found;
}

}  // namespace

OccModel::OccModel(const TopoDS_Shape& shape, std::string name, std::string unit,
                   std::vector<std::string> warnings)
    : shape_(shape), name_(std::move(name)), unit_(std::move(unit)), warnings_(std::move(warnings)) {
  TopExp::MapShapes(shape, TopAbs_VERTEX, node_map_);
  TopExp::MapShapes(shape, TopAbs_EDGE, edge_map_);
  TopExp::MapShapes(shape, TopAbs_FACE, face_map_);
  TopExp::MapShapes(shape, TopAbs_SOLID, body_map_);
  add_nodes();
  add_edges();
  add_faces();
  end_loose_lines();
}

void OccModel::add_nodes() {
  for (int i = 1; i <= node_map_.Extent(); ++i) {
    const TopoDS_Vertex& vertex = TopoDS::Vertex(node_map_(i));
    nodes_.push_back({point(BRep_Tool::Pnt(vertex)), BRep_Tool::Tolerance(vertex)});
  }
}

void OccModel::add_edges() {
  for (int i = 1; i <= edge_map_.Extent(); ++i) {
    const TopoDS_Edge edge = TopoDS::Edge(edge_map_(i).Oriented(TopAbs_FORWARD));
    ModelEdge e;
    Handle(Geom_Curve) curve;
    e.degenerate = BRep_Tool::Degenerated(edge);
    if (e.degenerate)
      BRep_Tool::Range(edge, e.begin, e.end);
    else
      curve = basis_of(BRep_Tool::Curve(edge, e.begin, e.end));
    e.degenerate |= curve.IsNull();
    e.tolerance = BRep_Tool::Tolerance(edge);
    TopoDS_Vertex first, last;
    TopExp::Vertices(edge, first, last);
    if (!first.IsNull()) e.nodes[0] = static_cast<std::uint32_t>(node_map_.FindIndex(first) - 1);
    if (!last.IsNull()) e.nodes[1] = static_cast<std::uint32_t>(node_map_.FindIndex(last) - 1);
    if (!curve.IsNull()) {
      e.form = form_of(curve);
      e.spans = spans_of(curve);
      e.spline = spline_of(curve);
      if (e.form.kind == CurveForm::Kind::circle)
        e.period = kTurn;
      else if (curve->IsPeriodic())
        e.period = curve->Period();
    }
    edges_.push_back(e);
    curves_.push_back(curve);
  }
}

void OccModel::add_faces() {
  for (int i = 1; i <= face_map_.Extent(); ++i) {
    const TopoDS_Face& face = TopoDS::Face(face_map_(i));
    const Handle(Geom_Surface) surface = basis_of(BRep_Tool::Surface(face));
    ModelFace f;
    BRepTools::UVBounds(TopoDS::Face(face.Oriented(TopAbs_FORWARD)), f.lo[0], f.hi[0], f.lo[1], f.hi[1]);
    surface->Bounds(f.first[0], f.last[0], f.first[1], f.last[1]);
    for (int k = 0; k < 2; ++k) {
      f.first[k] = bounded(f.first[k]);
      f.last[k] = bounded(f.last[k]);
    }
    // A closed surface that is not periodic is evaluated as if it were.
    if (surface->IsUClosed())
      f.period[0] = surface->IsUPeriodic() ? surface->UPeriod() : f.last[0] - f.first[0];
    if (surface->IsVClosed())
      f.period[1] = surface->IsVPeriodic() ? surface->VPeriod() : f.last[1] - f.first[1];
    f.tolerance = BRep_Tool::Tolerance(face);
    f.reversed = face.Orientation() == TopAbs_REVERSED;
    f.form = form_of(surface, f);
    f.spline = spline_of(surface);
    const GeomAdaptor_Surface adaptor(surface);
    f.spans = {std::max(1, adaptor.NbUIntervals(GeomAbs_C2)), std::max(1, adaptor.NbVIntervals(GeomAbs_C2))};
    faces_.push_back(f);
    surfaces_.push_back(surface);
    add_border(static_cast<std::uint32_t>(i - 1));
  }
}

void OccModel::add_border(std::uint32_t face) {
  const TopoDS_Face shape = TopoDS::Face(face_map_(static_cast<int>(face) + 1).Oriented(TopAbs_FORWARD));
  pcurves_.emplace_back();
  for (TopExp_Explorer at(shape, TopAbs_EDGE); at.More(); at.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(at.Current());
    const int index = edge_map_.FindIndex(edge);
    double first, last;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, shape, first, last);
    if (index == 0 || curve.IsNull()) continue;
    const auto use = [&](bool reversed) {
      faces_[face].border.push_back({static_cast<std::uint32_t>(index - 1), reversed});
      pcurves_[face].push_back(curve);
    };
    const TopAbs_Orientation way = edge.Orientation();
    if (way != TopAbs_REVERSED) use(false);
    if (way != TopAbs_FORWARD) use(true);  // an edge within the face has it on both sides
  }
}

/// Axes and other lines without ends that no face has are none of the body.
void OccModel::end_loose_lines() {
  TopTools_IndexedMapOfShape of_faces;
  for (int f = 1; f <= face_map_.Extent(); ++f) TopExp::MapShapes(face_map_(f), TopAbs_EDGE, of_faces);
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    ModelEdge& e = edges_[i];
    if (of_faces.Contains(edge_map_(static_cast<int>(i) + 1)) ||
        std::max(std::abs(e.begin), std::abs(e.end)) < 1e99)
      continue;
    e.degenerate = true;
    e.begin = 0;
    e.end = 1;
  }
}

/// OpenCASCADE's exceptions are none of the standard library's.
template <class Evaluate>
void OccModel::evaluating(const char* kind, std::uint32_t entity, const Evaluate& evaluate) const {
  try {
    evaluate();
  } catch (const Standard_Failure& failure) {
    throw InputError(name_, std::string(kind) + " " + std::to_string(entity + 1),
                     std::string("cannot be evaluated: ") + failure.GetMessageString());
  }
}

std::vector<std::uint32_t> OccModel::bodies_at(std::span<const Point> points) const {
  std::vector<std::uint32_t> bodies(points.size(), kNoEntity);
  for (std::uint32_t b = 0; b < num_bodies(); ++b)
    evaluating("body", b, [&] {
      for (const std::size_t i : points_in(body_map_(static_cast<int>(b) + 1), points)) bodies[i] = b;
    });
  return bodies;
}

CurveJet OccModel::curve(std::uint32_t edge, double t) const {
  gp_Pnt p;
  gp_Vec d1, d2;
  evaluating("edge", edge, [&] { curves_[edge]->D2(t, p, d1, d2); });
  return {point(p), vec(d1), vec(d2)};
}

SurfaceJet OccModel::surface(std::uint32_t face, const Parameters& at) const {
  const ModelFace& f = faces_[face];
  Parameters q = at;
  for (std::size_t i = 0; i < 2; ++i)
    if (f.period[i] > 0 && (q[i] < f.first[i] || q[i] > f.last[i]))
      q[i] = into_range(q[i], f.first[i], f.period[i]);
  gp_Pnt p;
  gp_Vec du, dv, duu, dvv, duv;
  evaluating("face", face, [&] { surfaces_[face]->D2(q[0], q[1], p, du, dv, duu, dvv, duv); });
  return {point(p), vec(du), vec(dv), vec(duu), vec(duv), vec(dvv)};
}

Parameters OccModel::on_face(std::uint32_t face, const EdgeUse& use, double t) const {
  const auto& border = faces_[face].border;
  for (std::size_t i = 0; i < border.size(); ++i) {
    if (border[i].edge != use.edge || border[i].reversed != use.reversed) continue;
    gp_Pnt2d p;
    evaluating("face", face, [&] { p = pcurves_[face][i]->Value(t); });
    return {p.X(), p.Y()};
  }
  return {};
}

}  // namespace weft::meshing
