// Derivatives of the sum of inverse mean ratios of a ball.
#include "meshing/ball_objective.h"

#include <algorithm>

namespace weft::meshing {
namespace {

/// h += s * (u v^T + v u^T) / 2
void add_symmetric(SymTensor& h, double s, const Vec& u, const Vec& v) {
  h.xx += s * u.x * v.x;
  h.yy += s * u.y * v.y;
  h.zz += s * u.z * v.z;
  h.xy += 0.5 * s * (u.x * v.y + u.y * v.x);
  h.xz += 0.5 * s * (u.x * v.z + u.z * v.x);
  h.yz += 0.5 * s * (u.y * v.z + u.z * v.y);
}

}  // namespace

void gather_faces(const TetMesh& mesh, const Ball& ball, std::vector<BallFace>& faces) {
  faces.clear();
  for (const auto& [t, local] : ball.tets) {
    const auto& f = kTetFaces[local];
    const VertexId a = mesh.vertex(t, f[0]), b = mesh.vertex(t, f[1]), c = mesh.vertex(t, f[2]);
    faces.push_back({{mesh.point(a), mesh.point(b), mesh.point(c)}, judge_tensor(mesh, a) + judge_tensor(mesh, b) + judge_tensor(mesh, c)});
  }
}

BallDerivatives ball_derivatives(MetricMean mean, const std::vector<BallFace>& faces, const Point& x, const SymTensor& centre) {
  BallDerivatives d;
  for (const BallFace& f : faces) {
    const SymTensor m = mean_of_sum(mean, f.tensor + centre);
    const Vec e1 = f.x[1] - f.x[0], e2 = f.x[2] - f.x[0], e3 = x - f.x[0];
    const Vec n = cross(e1, e2);  // gradient of the six-fold volume
    const double volume = dot(n, e3);
    if (!(volume > 0)) continue;
    const double s = sum_squared_lengths(m, e1, e2, e3);
    const double value = s / (kMeanRatioFactor * fast_cbrt(volume * volume * determinant(m) / 36));
    // S' = 2 M (3 x - sum of the face's points), S'' = 6 M.
    const Vec ds = (1 / s) * apply(m, 2.0 * (3.0 * e3 - e1 - e2));
    const Vec dv = (1 / volume) * n;
    const Vec g = ds - (2.0 / 3) * dv;  // gradient of the logarithm
    d.value += value;
    d.gradient += value * g;
    add_symmetric(d.hessian, value, g, g);
    add_symmetric(d.hessian, -value, ds, ds);
    add_symmetric(d.hessian, 2.0 / 3 * value, dv, dv);
    d.hessian = d.hessian + (6 * value / s) * m;
  }
  return d;
}

double ball_qualities(MetricMean mean, const std::vector<BallFace>& faces, const Point& x, const SymTensor& m, std::vector<float>& qualities) {
  qualities.clear();
  double least = 1;
  for (const BallFace& f : faces) {
    if (orientation(f.x[0], f.x[1], f.x[2], x) <= 0) return -1;
    const Vec e1 = f.x[1] - f.x[0], e2 = f.x[2] - f.x[0], e3 = x - f.x[0];
    const double volume = dot(cross(e1, e2), e3);
    const double q = volume > 0 ? mean_ratio(volume, mean_of_sum(mean, f.tensor + m), e1, e2, e3) : 0;
    least = std::min(least, q);
    qualities.push_back(static_cast<float>(q));
  }
  return least;
}

}  // namespace weft::meshing
