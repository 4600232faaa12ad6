// Moments as integers: a weight times a coordinate between -1 and 1, rounded, so that sums do not depend on
// their order.
#include "partition/decompose/inertia.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using meshing::Box;
using meshing::Point;
using meshing::SymTensor;
using meshing::Vec;

std::int64_t moment(std::uint64_t weight, double x) { return std::llround(static_cast<double>(weight) * x); }

Eigen::Matrix3d matrix(const SymTensor& t) {
  return Eigen::Matrix3d{{t.xx, t.xy, t.xz}, {t.xy, t.yy, t.yz}, {t.xz, t.yz, t.zz}};
}

/// This rank's sums of weight times tensor(i): six of each group.
template <class Tensor>
std::vector<std::int64_t> sums_here(const WeightedItems& items, std::span<const std::uint32_t> groups,
                                    std::uint32_t num_groups, const Tensor& tensor) {
  std::vector<std::int64_t> sums(6 * std::size_t{num_groups}, 0);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const SymTensor t = tensor(i);
    std::int64_t* sum = &sums[6 * std::size_t{groups[i]}];
    for (const double entry : {t.xx, t.xy, t.yy, t.xz, t.yz, t.zz}) *sum++ += moment(items.weights[i], entry);
  }
  return sums;
}

/// The sums of all ranks, as tensors.
std::vector<SymTensor> tensors_of(std::span<const std::int64_t> sums) {
  std::vector<SymTensor> result;
  for (; !sums.empty(); sums = sums.subspan(6)) {
    const auto entry = [&](std::size_t k) { return static_cast<double>(sums[k]); };
    result.push_back({entry(0), entry(1), entry(2), entry(3), entry(4), entry(5)});
  }
  return result;
}

/// Longest side of a box; 1 for a box without extent, which has nothing to be scaled by it.
double extent(const Box& box) {
  const Vec size = box.size();
  const double longest = std::max({size.x, size.y, size.z});
  return longest > 0 && std::isfinite(longest) ? longest : 1;
}

/// Weight, and weighted mean of the coordinates counted from the box's lower end in units of its extent.
struct Mean {
  double weight;
  Vec mean;
};

/// This rank's sums for the means: four of each group.
std::vector<std::int64_t> moments_here(const WeightedItems& items, std::span<const std::uint32_t> groups,
                                       const std::vector<Box>& boxes) {
  std::vector<std::int64_t> sums(4 * boxes.size(), 0);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Box& box = boxes[groups[i]];
    const Vec u = (1 / extent(box)) * (items.centres[i] - box.lo);
    std::int64_t* s = &sums[4 * std::size_t{groups[i]}];
    s[3] += static_cast<std::int64_t>(items.weights[i]);
    for (int k = 0; k < 3; ++k) s[k] += moment(items.weights[i], u[k]);
  }
  return sums;
}

/// From the sums of all ranks.
std::vector<Mean> means_of(std::span<const std::int64_t> sums) {
  std::vector<Mean> result;
  for (; !sums.empty(); sums = sums.subspan(4)) {
    const double weight = std::max(1.0, static_cast<double>(sums[3]));
    result.push_back({weight,
                      {static_cast<double>(sums[0]) / weight, static_cast<double>(sums[1]) / weight,
                       static_cast<double>(sums[2]) / weight}});
  }
  return result;
}

std::vector<SymTensor> covariances_about(Peers& peers, const WeightedItems& items,
                                         std::span<const std::uint32_t> groups, const std::vector<Box>& boxes,
                                         const std::vector<Mean>& means) {
  const auto num_groups = static_cast<std::uint32_t>(boxes.size());
  std::vector<SymTensor> result = tensors_of(
      partition::sum(peers, sums_here(items, groups, num_groups, [&](std::size_t i) {
                       const Box& box = boxes[groups[i]];
                       const Vec d = (1 / extent(box)) * (items.centres[i] - box.lo) - means[groups[i]].mean;
                       return SymTensor{d.x * d.x, d.x * d.y, d.y * d.y, d.x * d.z, d.y * d.z, d.z * d.z};
                     })));
  for (std::uint32_t g = 0; g < num_groups; ++g)
    for (double* entry :
         {&result[g].xx, &result[g].xy, &result[g].yy, &result[g].xz, &result[g].yz, &result[g].zz})
      *entry /= means[g].weight;
  return result;
}

std::vector<Box> boxes_here(std::span<const Point> points, std::span<const std::uint32_t> groups,
                            std::uint32_t num_groups) {
  std::vector<Box> boxes(num_groups);
  for (std::size_t i = 0; i < points.size(); ++i) boxes[groups[i]].include(points[i]);
  return boxes;
}

Box united(Box a, const Box& b) {
  a.unite(b);
  return a;
}

/// Of a group.
struct Extremes {
  Box box;
  double cut_tensor = 0;  ///< greatest trace
};

std::vector<Extremes> extremes_of(Peers& peers, const WeightedItems& items,
                                  std::span<const std::uint32_t> groups, std::uint32_t num_groups) {
  const std::vector<Box> boxes = boxes_here(items.centres, groups, num_groups);
  std::vector<Extremes> extremes(num_groups);
  for (std::uint32_t g = 0; g < num_groups; ++g) extremes[g].box = boxes[g];
  for (std::size_t i = 0; i < groups.size(); ++i)
    extremes[groups[i]].cut_tensor = std::max(extremes[groups[i]].cut_tensor, trace(items.cut_tensors[i]));
  return reduce(peers, extremes, [](const Extremes& a, const Extremes& b) {
    return Extremes{united(a.box, b.box), a.cut_tensor < b.cut_tensor ? b.cut_tensor : a.cut_tensor};
  });
}

}  // namespace

std::vector<Box> group_boxes(Peers& peers, std::span<const Point> points,
                             std::span<const std::uint32_t> groups, std::uint32_t num_groups) {
  return reduce(peers, boxes_here(points, groups, num_groups), united);
}

std::vector<SymTensor> covariances(Peers& peers, const WeightedItems& items,
                                   std::span<const std::uint32_t> groups, std::uint32_t num_groups) {
  const std::vector<Box> boxes = group_boxes(peers, items.centres, groups, num_groups);
  const std::vector<std::int64_t> moments = partition::sum(peers, moments_here(items, groups, boxes));
  return covariances_about(peers, items, groups, boxes, means_of(moments));
}

Axes principal_axes(const SymTensor& covariance) {
  const meshing::Eigen3 eigen = meshing::eigen_decomposition(covariance);
  Axes axes;
  for (int i = 0; i < 3; ++i) {
    const Vec& v = eigen.vectors[2 - i];
    int largest = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(v[k]) > std::abs(v[largest])) largest = k;
    axes[i] = v[largest] < 0 ? -1.0 * v : v;
  }
  return axes;
}

Vec cutting_axis(const SymTensor& covariance, const SymTensor& cut_tensor) {
  constexpr double kNearly = 0.9, kFlattest = 1e-12;
  const double size = trace(cut_tensor);
  const SymTensor s =
      size > 0 ? (1 / size) * cut_tensor + meshing::identity_tensor(kFlattest) : meshing::identity_tensor();
  const auto width = [&](const Vec& n) { return squared_length(covariance, n) / squared_length(s, n); };
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>;
  const Eigen::Matrix3d to_cuts = Solver(matrix(s)).operatorInverseSqrt();
  const Eigen::Matrix3d in_cuts = to_cuts * matrix(covariance) * to_cuts;
  const Eigen::Vector3d widest = (to_cuts * Solver(in_cuts).eigenvectors().col(2)).normalized();
  Vec best{widest[0], widest[1], widest[2]};
  if (!(norm(best) > 0.5)) best = {1, 0, 0};  // not solvable: as good as any
  Vec axis{1, 0, 0};
  for (const Vec& other : {Vec{0, 1, 0}, Vec{0, 0, 1}})
    if (width(other) > width(axis)) axis = other;
  return width(axis) < kNearly * width(best) ? best : axis;
}

std::vector<Vec> cutting_axes(Peers& peers, const WeightedItems& items, std::span<const std::uint32_t> groups,
                              std::uint32_t num_groups) {
  const std::vector<Extremes> extremes = extremes_of(peers, items, groups, num_groups);
  std::vector<Box> boxes;
  for (const Extremes& of_group : extremes) boxes.push_back(of_group.box);
  std::vector<std::int64_t> sums = moments_here(items, groups, boxes);
  const std::size_t num_moments = sums.size();
  const std::vector<std::int64_t> of_tensors = sums_here(items, groups, num_groups, [&](std::size_t i) {
    return (1 / extremes[groups[i]].cut_tensor) * items.cut_tensors[i];
  });
  sums.insert(sums.end(), of_tensors.begin(), of_tensors.end());
  sums = partition::sum(peers, sums);
  const std::span all(sums);
  const std::vector<SymTensor> spread =
      covariances_about(peers, items, groups, boxes, means_of(all.first(num_moments)));
  const std::vector<SymTensor> cut_tensors = tensors_of(all.subspan(num_moments));
  std::vector<Vec> axes;
  for (std::uint32_t g = 0; g < num_groups; ++g) axes.push_back(cutting_axis(spread[g], cut_tensors[g]));
  return axes;
}

}  // namespace weft::partition
