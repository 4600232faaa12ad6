// Preconditioned conjugate gradients (Saad, Iterative Methods for Sparse Linear Systems, 2003,
// algorithm 9.1).
#include "partition/coordinate/harmonic_solver.h"

#include <cmath>

#include "partition/coordinate/laplace_matrix.h"

namespace weft::partition {
namespace {

class ConjugateGradients {
 public:
  ConjugateGradients(const meshing::MetricDomain& domain, const std::vector<std::uint8_t>& fixed,
                     std::vector<double>& x)
      : domain_(domain),
        fixed_(fixed),
        matrix_(domain),
        x_(x),
        r_(x.size(), 0),
        p_(x.size(), 0),
        q_(x.size(), 0) {}

  Solved run(double tolerance, int most_steps);

 private:
  /// Whether the row of v is solved for here. A vertex of no tet has none.
  bool free(std::size_t v) const { return domain_.owns(v) && !fixed_[v] && matrix_.diagonal(v) > 0; }
  /// r.z with z = r over the diagonal.
  double residual() const {
    return domain_.sum([&](std::size_t v) { return free(v) ? r_[v] * r_[v] / matrix_.diagonal(v) : 0; });
  }
  template <class Action>
  void for_free(const Action& action) {
    for (std::size_t v = 0; v < x_.size(); ++v)
      if (free(v)) action(v);
  }

  const meshing::MetricDomain& domain_;
  const std::vector<std::uint8_t>& fixed_;
  const LaplaceMatrix matrix_;
  std::vector<double>& x_;
  std::vector<double> r_, p_, q_;  ///< residual, direction, matrix times direction
};

Solved ConjugateGradients::run(double tolerance, int most_steps) {
  matrix_.multiply(x_, q_);
  for_free([&](std::size_t v) { r_[v] = -q_[v]; });
  const double first = residual();
  double now = first, beta = 0;
  Solved solved;
  const auto reduction = [&] { return first > 0 ? std::sqrt(now / first) : 0; };
  for (; solved.steps < most_steps && reduction() > tolerance; ++solved.steps) {
    for_free([&](std::size_t v) { p_[v] = r_[v] / matrix_.diagonal(v) + beta * p_[v]; });
    domain_.refresh(1, p_);
    matrix_.multiply(p_, q_);
    const double curvature = domain_.signed_sum([&](std::size_t v) { return free(v) ? p_[v] * q_[v] : 0; });
    if (!(curvature > 0)) break;  // rounding: nothing is left to be gained along p
    const double alpha = now / curvature;
    for_free([&](std::size_t v) {
      x_[v] += alpha * p_[v];
      r_[v] -= alpha * q_[v];
    });
    const double before = now;
    now = residual();
    beta = now / before;
  }
  domain_.refresh(1, x_);
  solved.reduction = reduction();
  return solved;
}

}  // namespace

Solved solve_harmonic(const meshing::MetricDomain& domain, const std::vector<std::uint8_t>& fixed,
                      double tolerance, int most_steps, std::vector<double>& values) {
  return ConjugateGradients(domain, fixed, values).run(tolerance, most_steps);
}

}  // namespace weft::partition
