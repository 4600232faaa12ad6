// Merging of points; degenerate triangles give way to their neighbours.
#include "meshing/initial/clean_triangles.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

bool collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

/// Whether the corners of t stand in the order of their numbers, up to a rotation.
bool ascends(const Triangle& t) { return (t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0]) == 2; }

/// Numbers of points after those nearer than `tolerance` to an earlier one have become that one.
class NearbyPoints {
 public:
  NearbyPoints(const std::vector<Point>& points, double tolerance)
      : points_(points), tolerance_(tolerance), cell_(std::max(2 * tolerance, 1e-300)) {}

  /// The earlier point that point i coincides with, or i.
  std::uint32_t find_or_add(std::uint32_t i) {
    const Point& p = points_[i];
    for (int k = 0; k < 8; ++k) {
      const Point q = {p.x + (k & 1 ? 1 : -1) * tolerance_, p.y + (k & 2 ? 1 : -1) * tolerance_,
                       p.z + (k & 4 ? 1 : -1) * tolerance_};
      const auto [begin, end] = cells_.equal_range(hash(q));
      for (auto at = begin; at != end; ++at)
        if (norm2(points_[at->second] - p) <= tolerance_ * tolerance_) return at->second;
    }
    cells_.emplace(hash(p), i);
    return i;
  }

 private:
  std::uint64_t hash(const Point& p) const {
    std::uint64_t h = 0;
    for (int i = 0; i < 3; ++i)
      h = (h ^ std::hash<double>{}(std::floor(p[i] / cell_) + 0.0)) * 0x9E3779B97F4A7C15u;
    return h;
  }

  const std::vector<Point>& points_;
  double tolerance_, cell_;
  std::unordered_multimap<std::uint64_t, std::uint32_t> cells_;
};

}  // namespace

void LooseTriangles::push_back_piece(std::size_t of, const Triangle& piece) {
  corners.push_back(piece);
  refs.push_back(refs[of]);
  source.push_back(source[of]);
  sheets.push_back(sheets[of]);
}

std::size_t LooseTriangles::erase(const std::vector<bool>& drop) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (drop[i]) continue;
    corners[kept] = corners[i];
    refs[kept] = refs[i];
    source[kept] = source[i];
    sheets[kept++] = sheets[i];
  }
  const std::size_t count = corners.size() - kept;
  corners.resize(kept), refs.resize(kept), source.resize(kept), sheets.resize(kept);
  return count;
}

std::size_t TriangleCleaning::merge_points() {
  std::vector<bool> used(points_.size());
  for (const Triangle& t : triangles_.corners)
    for (const std::uint32_t v : t) used[v] = true;
  NearbyPoints nearby(points_, tolerance_);
  merged_.assign(points_.size(), kUnused);
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < merged_.size(); ++i) {
    if (!used[i]) continue;
    merged_[i] = nearby.find_or_add(i);
    count += merged_[i] != i;
  }
  for (Triangle& t : triangles_.corners)
    for (std::uint32_t& v : t) v = merged_[v];
  return count;
}

std::size_t TriangleCleaning::drop_collapsed() {
  std::vector<bool> drop(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); ++i) drop[i] = collapsed(triangles_.corners[i]);
  return triangles_.erase(drop);
}

/// The corner opposite the longest edge when it lies on that edge, up to the tolerance; else -1.
int TriangleCleaning::corner_on_edge(const Triangle& t) const {
  const auto& p = points_;
  int apex = 0;
  double longest = 0;
  for (int k = 0; k < 3; ++k) {
    const double length = norm(p[t[(k + 1) % 3]] - p[t[(k + 2) % 3]]);
    if (length <= longest) continue;
    longest = length;
    apex = k;
  }
  const double area = norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
  const bool flat = area <= tolerance_ * longest || collinear(p[t[0]], p[t[1]], p[t[2]]);
  return flat ? apex : -1;
}

bool TriangleCleaning::is_between(const Triangle& t, int apex) const {
  const auto& p = points_;
  const Point &a = p[t[(apex + 1) % 3]], &b = p[t[(apex + 2) % 3]], &c = p[t[apex]];
  return std::max(norm(c - a), norm(c - b)) < norm(b - a);
}

std::size_t TriangleCleaning::mend_degenerate() {
  constexpr int kMostRounds = 20;
  std::size_t count = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    const std::size_t mended = mend_round();
    if (mended == 0) break;
    count += mended;
  }
  return count;
}

std::size_t TriangleCleaning::mend_round() {
  std::unordered_map<std::uint64_t, std::uint32_t> splits;  // edge -> the vertex on it
  std::vector<bool> drop(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const Triangle& t = triangles_.corners[i];
    const int apex = corner_on_edge(t);
    if (apex < 0 || !is_between(t, apex)) continue;
    drop[i] = splits.try_emplace(edge_key(t[(apex + 1) % 3], t[(apex + 2) % 3]), t[apex]).second;
  }
  if (splits.empty()) return 0;
  for (std::size_t i = 0; i < triangles_.size(); ++i)
    while (!drop[i] && split_at(i, splits, drop)) continue;
  triangles_.erase(drop);
  splits_.insert(splits.begin(), splits.end());
  return splits.size();
}

/// Whether it was split: the parts, which have shorter edges, may have one more to be split at.
bool TriangleCleaning::split_at(std::size_t i, const std::unordered_map<std::uint64_t, std::uint32_t>& splits,
                                std::vector<bool>& drop) {
  const Triangle t = triangles_.corners[i];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
    const auto at = splits.find(edge_key(a, b));
    if (at == splits.end()) continue;
    if (at->second == c) {
      drop[i] = true;
      return false;
    }
    triangles_.corners[i] = {a, at->second, c};
    triangles_.push_back_piece(i, {at->second, b, c});
    drop.push_back(false);
    return true;
  }
  return false;
}

std::size_t TriangleCleaning::merge_repeated() {
  std::vector<std::uint32_t> order(triangles_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<Triangle> keys(triangles_.size());
  std::transform(triangles_.corners.begin(), triangles_.corners.end(), keys.begin(), sorted);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  std::vector<bool> drop(triangles_.size());
  std::size_t first = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (keys[order[i]] != keys[order[first]]) {
      first = i;
      continue;
    }
    drop[order[i]] = true;
    repeated_.push_back({triangles_.source[order[i]], triangles_.source[order[first]]});
    const bool alike = ascends(triangles_.corners[order[i]]) == ascends(triangles_.corners[order[first]]);
    triangles_.sheets[order[first]] += (alike ? 1 : -1) * triangles_.sheets[order[i]];
  }
  return triangles_.erase(drop);
}

}  // namespace weft::meshing
