// Poor triangles wait in a queue; a flip puts those back that are still poor or have a new neighbour.
#include "meshing/cad/lay_triangles.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>

namespace weft::meshing {
namespace {

constexpr double kStands = 0.5;     // cosine of the angle between the normals
constexpr double kLine = 1e-7;      // height by length
constexpr double kClearly = 1e-12;  // better by less is rounding
constexpr std::size_t kMostFlipsEach = 20;

VertexPair side_of(std::uint32_t a, std::uint32_t b) { return std::minmax(a, b); }

class Flips {
 public:
  Flips(const GeometryModel& model, std::uint32_t face, std::span<const Point> points,
        const std::set<VertexPair>& fixed, const std::set<std::uint32_t>& poles,
        std::vector<FaceTriangle>& triangles)
      : model_(model), face_(face), points_(points), fixed_(fixed), poles_(poles), triangles_(triangles) {}

  void run() {
    waits_.assign(triangles_.size(), false);
    for (std::size_t i = 0; i < triangles_.size(); ++i) queue_if_poor(i);
    if (queue_.empty()) return;
    for (std::size_t i = 0; i < triangles_.size(); ++i) enter(i);
    for (std::size_t left = kMostFlipsEach * triangles_.size(); !queue_.empty() && left > 0;) {
      const std::size_t i = queue_.front();
      queue_.pop_front();
      waits_[i] = false;
      if (is_poor(triangles_[i]) && flip_best(i)) --left;
    }
  }

 private:
  struct Flip {
    std::size_t other = 0;
    std::array<FaceTriangle, 2> become;
    double gain = kClearly;
  };

  Vec normal_of(const FaceTriangle& t) const {
    return cross(points_[t.v[1]] - points_[t.v[0]], points_[t.v[2]] - points_[t.v[0]]);
  }

  double longest2(const FaceTriangle& t) const {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, norm2(points_[t.v[(k + 1) % 3]] - points_[t.v[k]]));
    return longest;
  }

  /// Of the surface amid the corners that are no poles, on the body's outside.
  Vec up(const FaceTriangle& t) const {
    Parameters at{};
    int count = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (!poles_.contains(t.v[k])) {
        for (std::size_t j = 0; j < 2; ++j) at[j] += t.at[k][j];
        ++count;
      }
    if (count == 0) return {};
    for (double& x : at) x /= count;
    const SurfaceJet jet = model_.surface(face_, at);
    const Vec n = cross(jet.du, jet.dv);
    const double length = norm(n);
    if (!(length > 0)) return {};
    return ((model_.faces()[face_].reversed ? -1 : 1) / length) * n;
  }

  /// Twice the area seen along the surface's normal, by the longest side's square.
  double score(const FaceTriangle& t) const { return dot(normal_of(t), up(t)) / longest2(t); }

  bool is_poor(const FaceTriangle& t) const {
    const Vec n = normal_of(t);
    return norm(n) <= kLine * longest2(t) || dot(n, up(t)) < kStands * norm(n);
  }

  void queue_if_poor(std::size_t i) {
    if (waits_[i] || !is_poor(triangles_[i])) return;
    waits_[i] = true;
    queue_.push_back(i);
  }

  void enter(std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k)
      at_side_[side_of(triangles_[i].v[k], triangles_[i].v[(k + 1) % 3])].push_back(i);
  }

  void leave(std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = at_side_.find(side_of(triangles_[i].v[k], triangles_[i].v[(k + 1) % 3]));
      std::erase(at->second, i);
      if (at->second.empty()) at_side_.erase(at);
    }
  }

  /// Of side k of triangle i, where it is better than `best`.
  void consider(std::size_t i, std::size_t k, Flip& best) const {
    const FaceTriangle& t = triangles_[i];
    const std::size_t b = (k + 1) % 3, c = (k + 2) % 3;
    const VertexPair side = side_of(t.v[k], t.v[b]);
    const auto& both = at_side_.at(side);
    if (both.size() != 2 || fixed_.contains(side)) return;
    const std::size_t other = both[0] == i ? both[1] : both[0];
    const FaceTriangle& n = triangles_[other];
    for (std::size_t m = 0; m < 3; ++m) {
      if (n.v[m] != t.v[b] || n.v[(m + 1) % 3] != t.v[k]) continue;
      const std::size_t d = (m + 2) % 3;
      if (n.v[d] == t.v[c] || at_side_.contains(side_of(n.v[d], t.v[c]))) return;
      const std::array<FaceTriangle, 2> become = {
          FaceTriangle{{t.v[k], n.v[d], t.v[c]}, {t.at[k], n.at[d], t.at[c]}},
          FaceTriangle{{n.v[d], t.v[b], t.v[c]}, {n.at[d], t.at[b], t.at[c]}}};
      const double gain = std::min(score(become[0]), score(become[1])) - std::min(score(t), score(n));
      if (gain > best.gain) best = {other, become, gain};
    }
  }

  bool flip_best(std::size_t i) {
    Flip best;
    for (std::size_t k = 0; k < 3; ++k) consider(i, k, best);
    if (best.gain <= kClearly) return false;
    for (const std::size_t x : {i, best.other}) leave(x);
    triangles_[i] = best.become[0];
    triangles_[best.other] = best.become[1];
    for (const std::size_t x : {i, best.other}) enter(x);
    for (const std::size_t x : {i, best.other})
      for (std::size_t k = 0; k < 3; ++k)
        for (const std::size_t near : at_side_.at(side_of(triangles_[x].v[k], triangles_[x].v[(k + 1) % 3])))
          queue_if_poor(near);
    return true;
  }

  const GeometryModel& model_;
  const std::uint32_t face_;
  const std::span<const Point> points_;
  const std::set<VertexPair>& fixed_;
  const std::set<std::uint32_t>& poles_;
  std::vector<FaceTriangle>& triangles_;
  std::map<VertexPair, std::vector<std::size_t>> at_side_;
  std::deque<std::size_t> queue_;
  std::vector<bool> waits_;  // in the queue
};

}  // namespace

void lay_triangles(const GeometryModel& model, std::uint32_t face, std::span<const Point> points,
                   const std::set<VertexPair>& fixed, const std::set<std::uint32_t>& poles,
                   std::vector<FaceTriangle>& triangles) {
  Flips(model, face, points, fixed, poles, triangles).run();
}

}  // namespace weft::meshing
