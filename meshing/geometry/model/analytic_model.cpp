// Balls and frustums out of closed forms.
#include "meshing/geometry/model/analytic_model.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace weft::meshing {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

class AnalyticModel : public GeometryModel {
 public:
  std::span<const ModelNode> nodes() const override { return nodes_; }
  std::span<const ModelEdge> edges() const override { return edges_; }
  std::span<const ModelFace> faces() const override { return faces_; }
  CurveJet curve(std::uint32_t edge, double t) const override { return evaluate(edges_[edge].form, t); }
  SurfaceJet surface(std::uint32_t face, const Parameters& at) const override {
    return evaluate(faces_[face].form, at);
  }
  /// Edges run along an angle or along a height; both are parameters of the side.
  Parameters on_face(std::uint32_t face, const EdgeUse& use, double t) const override {
    const ModelEdge& e = edges_[use.edge];
    if (faces_[face].form.kind == SurfaceForm::Kind::plane)
      return {e.form.radius * std::cos(t), e.form.radius * std::sin(t)};
    if (e.form.kind == CurveForm::Kind::line) return {use.reversed ? 0 : kTurn, t};
    return {t, use.edge == 0 ? faces_[face].lo[1] : faces_[face].hi[1]};
  }
  const std::string& name() const override { return name_; }
  const std::string& unit() const override { return unit_; }
  std::span<const std::string> warnings() const override { return {}; }

  std::string name_, unit_;
  std::vector<ModelNode> nodes_;
  std::vector<ModelEdge> edges_;
  std::vector<ModelFace> faces_;
};

ModelEdge circle(const Point& centre, double radius, std::uint32_t node) {
  ModelEdge e;
  e.form = {CurveForm::Kind::circle, {centre}, radius};
  e.begin = 0;
  e.end = e.period = kTurn;
  e.nodes = {node, node};
  e.degenerate = radius == 0;
  return e;
}

ModelFace disk(const Point& centre, double radius, std::uint32_t edge, bool reversed) {
  ModelFace f;
  f.form.kind = SurfaceForm::Kind::plane;
  f.form.frame.origin = centre;
  f.lo = {-radius, -radius};
  f.hi = {radius, radius};
  f.border = {{edge, reversed}};
  f.reversed = reversed;
  return f;
}

class WithoutFormulas : public GeometryModel {
 public:
  explicit WithoutFormulas(std::shared_ptr<const GeometryModel> model) : model_(std::move(model)) {
    edges_.assign(model_->edges().begin(), model_->edges().end());
    faces_.assign(model_->faces().begin(), model_->faces().end());
    for (ModelEdge& e : edges_) e.form = {};
    for (ModelFace& f : faces_) f.form = {};
  }
  std::span<const ModelNode> nodes() const override { return model_->nodes(); }
  std::span<const ModelEdge> edges() const override { return edges_; }
  std::span<const ModelFace> faces() const override { return faces_; }
  CurveJet curve(std::uint32_t edge, double t) const override { return model_->curve(edge, t); }
  SurfaceJet surface(std::uint32_t face, const Parameters& at) const override {
    return model_->surface(face, at);
  }
  Parameters on_face(std::uint32_t face, const EdgeUse& use, double t) const override {
    return model_->on_face(face, use, t);
  }
  const std::string& name() const override { return model_->name(); }
  const std::string& unit() const override { return model_->unit(); }
  std::span<const std::string> warnings() const override { return model_->warnings(); }

 private:
  std::shared_ptr<const GeometryModel> model_;
  std::vector<ModelEdge> edges_;
  std::vector<ModelFace> faces_;
};

}  // namespace

std::shared_ptr<const GeometryModel> ball_model(const Point& centre, double radius) {
  auto model = std::make_shared<AnalyticModel>();
  model->name_ = "ball";
  ModelFace f;
  f.form.kind = SurfaceForm::Kind::sphere;
  f.form.frame.origin = centre;
  f.form.radius = radius;
  f.lo = {0, -kTurn / 4};
  f.hi = {kTurn, kTurn / 4};
  f.first = f.lo;
  f.last = f.hi;
  f.period = {kTurn, 0};
  model->faces_.push_back(f);
  return model;
}

std::shared_ptr<const GeometryModel> frustum_model(const Point& base, double lower_radius,
                                                   double upper_radius, double height) {
  auto model = std::make_shared<AnalyticModel>();
  model->name_ = "frustum";
  const Point top = base + Vec{0, 0, height};
  const Point a = base + Vec{lower_radius, 0, 0}, b = top + Vec{upper_radius, 0, 0};
  const double length = norm(b - a);
  model->nodes_ = {{a}, {b}};
  model->edges_ = {circle(base, lower_radius, 0), circle(top, upper_radius, 1), {}};
  ModelEdge& seam = model->edges_.back();
  seam.form.kind = CurveForm::Kind::line;
  seam.form.frame.origin = a;
  seam.form.frame.x = (1 / length) * (b - a);
  seam.begin = 0;
  seam.end = length;
  seam.nodes = {0, 1};
  ModelFace side;
  const bool cylinder = lower_radius == upper_radius;
  side.form.kind = cylinder ? SurfaceForm::Kind::cylinder : SurfaceForm::Kind::cone;
  side.form.frame.origin = base;
  side.form.radius = lower_radius;
  side.form.second = cylinder ? 0 : std::atan2(upper_radius - lower_radius, height);
  side.lo = {0, 0};
  side.hi = {kTurn, length};
  side.period = {kTurn, 0};
  side.border = {{0, false}, {2, false}, {1, true}, {2, true}};
  model->faces_ = {side, disk(base, lower_radius, 0, true)};
  if (upper_radius > 0) model->faces_.push_back(disk(top, upper_radius, 1, false));
  return model;
}

std::shared_ptr<const GeometryModel> without_formulas(std::shared_ptr<const GeometryModel> model) {
  return std::make_shared<WithoutFormulas>(std::move(model));
}

}  // namespace weft::meshing
