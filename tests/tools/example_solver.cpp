// A small solver for `weft loop`: linear finite elements for -Laplace(u) = f in the unit cube, with f and the
// boundary values made from a known u, so that the error can be told. "sample" takes u itself at the
// vertices: what is left is the error of interpolation.
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "meshing/io/mesh_file.h"
#include "meshing/mesh/mesh_data.h"

namespace {

using weft::meshing::MeshData;
using weft::meshing::Point;
using weft::meshing::Tet;
using weft::meshing::Vec;

struct KnownField {
  std::function<double(const Point&)> value, laplacian;
};

constexpr double kPi = std::numbers::pi;

double waves(const Point& p) {
  return std::sin(2 * kPi * p.x) * std::sin(2 * kPi * p.y) * std::sin(2 * kPi * p.z);
}

/// A layer of thickness 0.01 at x = 0.
constexpr double kLayer = 0.01;
double across(double y, double z) { return std::sin(kPi * y) * std::cos(kPi * z); }

/// A sphere of radius 0.7 round the origin over which the field jumps within 0.001.
constexpr double kShock = 1e-3, kRadius = 0.7;

const std::map<std::string, KnownField> kFields = {
    {"smooth", {waves, [](const Point& p) { return -12 * kPi * kPi * waves(p); }}},
    {"layer",
     {[](const Point& p) { return (1 - std::exp(-p.x / kLayer)) * across(p.y, p.z); },
      [](const Point& p) {
        const double e = std::exp(-p.x / kLayer);
        return (-e / (kLayer * kLayer) - 2 * kPi * kPi * (1 - e)) * across(p.y, p.z);
      }}},
    {"shock",
     {[](const Point& p) { return std::tanh((norm(p) - kRadius) / kShock); },
      [](const Point& p) {
        const double r = norm(p), t = std::tanh((r - kRadius) / kShock), slope = (1 - t * t) / kShock;
        return -2 * t * slope / kShock + (r > 0 ? 2 / r * slope : 0);
      }}}};

/// Gauss's rule of four points in each collapsed coordinate: weights of sum 1 at barycentric coordinates.
struct Quadrature {
  struct Node {
    std::array<double, 4> at;
    double weight;
  };
  std::vector<Node> nodes;

  Quadrature() {
    constexpr double kAt[] = {0.0694318442029737, 0.3300094782075719, 0.6699905217924281, 0.9305681557970263};
    constexpr double kWeight[] = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                  0.1739274225687269};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k) {
          const double a = kAt[i], b = kAt[j] * (1 - a), c = kAt[k] * (1 - a - b);
          const double jacobian = 6 * (1 - a) * (1 - a - b);
          nodes.push_back({{1 - a - b - c, a, b, c}, jacobian * kWeight[i] * kWeight[j] * kWeight[k]});
        }
  }
};
const Quadrature kQuadrature;

std::array<Point, 4> corners(const MeshData& mesh, const Tet& tet) {
  return {mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]};
}

Point at(const std::array<Point, 4>& x, const std::array<double, 4>& l) {
  return l[0] * x[0] + l[1] * x[1] + (l[2] * x[2] + l[3] * x[3]);
}

double volume(const std::array<Point, 4>& x) { return six_volume(x[0], x[1], x[2], x[3]) / 6; }

std::vector<double> sample(const MeshData& mesh, const KnownField& field) {
  std::vector<double> values;
  for (const Point& p : mesh.points) values.push_back(field.value(p));
  return values;
}

/// Stiffness and load of the vertices within; boundary values move to the right side.
class Poisson {
 public:
  Poisson(const MeshData& mesh, const KnownField& field)
      : mesh_(mesh), field_(field), values_(sample(mesh, field)), row_(mesh.points.size(), 0) {
    for (const auto& triangle : mesh.triangles)
      for (const std::uint32_t v : triangle) row_[v] = -1;
    for (int& row : row_)
      if (row == 0) row = size_++;
  }

  std::vector<double> solve() {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(size_);
    std::vector<Eigen::Triplet<double>> entries;
    for (const Tet& tet : mesh_.tets) add(tet, entries, load);
    Eigen::SparseMatrix<double> stiffness(size_, size_);
    stiffness.setFromTriplets(entries.begin(), entries.end());
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                             Eigen::IncompleteCholesky<double>>
        solver(stiffness);
    solver.setTolerance(1e-11);
    const Eigen::VectorXd inner = solver.solve(load);
    if (solver.info() != Eigen::Success) throw std::runtime_error("the linear system did not converge");
    for (std::size_t v = 0; v < row_.size(); ++v)
      if (row_[v] >= 0) values_[v] = inner[row_[v]];
    return values_;
  }

 private:
  void add(const Tet& tet, std::vector<Eigen::Triplet<double>>& entries, Eigen::VectorXd& load) const {
    const auto x = corners(mesh_, tet);
    const double v = volume(x);
    std::array<Vec, 4> gradients;
    for (std::size_t i = 1; i < 4; ++i)
      gradients[i] = 1 / (6 * v) * cross(x[1 + i % 3] - x[0], x[1 + (i + 1) % 3] - x[0]);
    gradients[0] = -1 * (gradients[1] + gradients[2] + gradients[3]);
    for (std::size_t i = 0; i < 4; ++i) {
      const int row = row_[tet[i]];
      if (row < 0) continue;
      for (const auto& node : kQuadrature.nodes)
        load[row] -= v * node.weight * node.at[i] * field_.laplacian(at(x, node.at));
      for (std::size_t j = 0; j < 4; ++j) {
        const double entry = v * dot(gradients[i], gradients[j]);
        if (row_[tet[j]] >= 0)
          entries.emplace_back(row, row_[tet[j]], entry);
        else
          load[row] -= entry * values_[tet[j]];
      }
    }
  }

  const MeshData& mesh_;
  const KnownField& field_;
  std::vector<double> values_;
  std::vector<int> row_;  ///< of the unknown at a vertex; -1 on the boundary
  int size_ = 0;
};

double l2_error(const MeshData& mesh, const KnownField& field, const std::vector<double>& values) {
  const auto error2 = [&](const Tet& tet) {
    const auto x = corners(mesh, tet);
    double sum = 0;
    for (const auto& node : kQuadrature.nodes) {
      double u = -field.value(at(x, node.at));
      for (std::size_t i = 0; i < 4; ++i) u += node.at[i] * values[tet[i]];
      sum += node.weight * u * u;
    }
    return volume(x) * sum;
  };
  return std::sqrt(tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.tets.size(), 1024), 0.0,
      [&](const tbb::blocked_range<std::size_t>& range, double sum) {
        for (std::size_t t = range.begin(); t < range.end(); ++t) sum += error2(mesh.tets[t]);
        return sum;
      },
      std::plus<>()));
}

int run(const std::string& method, const std::string& field_name, const std::string& mesh_file,
        const std::string& solution_file) {
  const auto field = kFields.find(field_name);
  if ((method != "sample" && method != "poisson") || field == kFields.end()) {
    fmt::print(stderr, "usage: weft_example_solver sample|poisson smooth|layer|shock MESH SOLUTION\n");
    return 64;
  }
  const MeshData mesh = weft::meshing::read_mesh(mesh_file);
  const std::vector<double> values =
      method == "sample" ? sample(mesh, field->second) : Poisson(mesh, field->second).solve();
  weft::meshing::write_solution(
      solution_file, {mesh.points.size(), {{weft::meshing::Field::Kind::scalar, values, field_name}}});
  fmt::print("{{\"vertices\": {}, \"tets\": {}, \"l2_error\": {:.6e}}}\n", mesh.points.size(),
             mesh.tets.size(), l2_error(mesh, field->second, values));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> words(argv, argv + argc);
    return words.size() == 5 ? run(words[1], words[2], words[3], words[4]) : run("", "", "", "");
  } catch (const std::exception& error) {
    fmt::print(stderr, "weft_example_solver: {}\n", error.what());
    return 1;
  }
}
