// Sums and products of doubles are exact in CGAL's Mpzf; no quotient is ever needed but a rounded one.
#include "meshing/initial/grid/exact_place.h"

#include <CGAL/Interval_nt.h>
#include <CGAL/Mpzf.h>
#include <CGAL/Simple_cartesian.h>

namespace weft::meshing {
namespace {

using Exact = CGAL::Mpzf;
using Interval = CGAL::Interval_nt_advanced;

template <class Number>
using PointOf = typename CGAL::Simple_cartesian<Number>::Point_3;

template <class Number>
Number value(const Parameter& p) {
  Number sum(p.terms[0]);
  for (std::size_t i = 1; i < p.terms.size() && p.terms[i] != 0; ++i) sum += Number(p.terms[i]);
  return sum;
}

template <class Number>
PointOf<Number> evaluate(const ExactPlace& p) {
  if (p.s.terms[0] == 0 && p.t.terms[0] == 0)
    return {Number(p.origin.x), Number(p.origin.y), Number(p.origin.z)};
  const Number s = value<Number>(p.s), t = value<Number>(p.t);
  const auto coordinate = [&](double o, double u, double v) {
    return Number(o) + s * (Number(u) - Number(o)) + t * (Number(v) - Number(o));
  };
  return {coordinate(p.origin.x, p.u.x, p.v.x), coordinate(p.origin.y, p.u.y, p.v.y),
          coordinate(p.origin.z, p.u.z, p.v.z)};
}

/// det(b-a, c-a, d-a)
Exact volume(const PointOf<Exact>& a, const PointOf<Exact>& b, const PointOf<Exact>& c,
             const PointOf<Exact>& d) {
  return CGAL::determinant(b - a, c - a, d - a);
}

Parameter quotient(Exact dividend, const Exact& divisor) {
  Parameter result;
  for (double& term : result.terms) {
    term = CGAL::to_double(dividend) / CGAL::to_double(divisor);
    dividend -= Exact(term) * divisor;
  }
  return result;
}

}  // namespace

Point ExactPlace::rounded() const {
  const PointOf<Exact> p = evaluate<Exact>(*this);
  return {CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())};
}

int orientation(const ExactPlace& a, const ExactPlace& b, const ExactPlace& c, const ExactPlace& d) {
  {
    const Interval::Protector rounding;
    const auto sign = CGAL::orientation(evaluate<Interval>(a), evaluate<Interval>(b), evaluate<Interval>(c),
                                        evaluate<Interval>(d));
    if (CGAL::is_certain(sign)) return static_cast<int>(CGAL::get_certain(sign));
  }
  return static_cast<int>(
      CGAL::orientation(evaluate<Exact>(a), evaluate<Exact>(b), evaluate<Exact>(c), evaluate<Exact>(d)));
}

ExactPlace place_on_edge(const Point& a, const Point& b, const std::array<ExactPlace, 3>& triangle) {
  const auto x = evaluate<Exact>(triangle[0]), y = evaluate<Exact>(triangle[1]),
             z = evaluate<Exact>(triangle[2]);
  const Exact from_a = volume(x, y, z, evaluate<Exact>(ExactPlace::at(a)));
  const Exact from_b = volume(x, y, z, evaluate<Exact>(ExactPlace::at(b)));
  return {a, b, a, quotient(from_a, from_a - from_b), {}};
}

ExactPlace place_on_facet(const std::array<Point, 3>& triangle, const ExactPlace& p, const ExactPlace& q) {
  const auto a = evaluate<Exact>(ExactPlace::at(triangle[0])),
             b = evaluate<Exact>(ExactPlace::at(triangle[1])),
             c = evaluate<Exact>(ExactPlace::at(triangle[2])), from = evaluate<Exact>(p),
             to = evaluate<Exact>(q);
  const Exact of_a = volume(from, to, b, c), of_b = volume(from, to, c, a), of_c = volume(from, to, a, b);
  const Exact all = of_a + of_b + of_c;
  return {triangle[0], triangle[1], triangle[2], quotient(of_b, all), quotient(of_c, all)};
}

}  // namespace weft::meshing
