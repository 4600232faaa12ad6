// Worst tets first: each starts a cavity that a vertex nearby, or a new one, fills with better tets.
#include "meshing/initial/recovery/improve_tets.h"

#include <algorithm>
#include <queue>

#include "meshing/initial/grid/star_cavity.h"

namespace weft::meshing {
namespace {

class Improvement {
 public:
  explicit Improvement(TetGrid& grid) : grid_(grid), cavity_(grid) {}

  void run() {
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) enqueue(t);
    spare_ = grid_.add_point({});
    for (std::size_t left = kMostPerTet * grid_.tets.size(); left > 0 && !queue_.empty(); --left) {
      const Poor worst = queue_.top();
      queue_.pop();
      if (grid_.alive(worst.tet) && grid_.tets[worst.tet].v == worst.vertices) improve(worst);
    }
  }

 private:
  static constexpr double kPoor = 0.002;  ///< of TetGrid::shape; a regular tet has 0.048
  static constexpr std::size_t kMostPerTet = 10;
  struct Poor {
    double shape;
    std::uint32_t tet;
    Tet4 vertices;
    bool operator<(const Poor& other) const {
      return shape != other.shape ? shape > other.shape : tet > other.tet;
    }
  };

  void enqueue(std::uint32_t t) {
    if (!grid_.alive(t)) return;
    const double shape = grid_.shape(grid_.tets[t].v);
    if (shape < kPoor) queue_.push({shape, t, grid_.tets[t].v});
  }

  /// Twice as good at least, or nothing: else tets would go on improving for ever.
  void improve(const Poor& poor) {
    Star star;
    star.worst = 2 * poor.shape;
    cavity_.begin(kNothing, std::span(&poor.tet, 1), {}, {});
    list_nearby(poor.tet);
    for (const std::uint32_t v : nearby_) cavity_.improve(star, v);
    Point place;
    for (const std::size_t origins : {1u, 7u}) {
      if (!star.fresh.empty()) break;
      for (const Point& p : places(poor.tet, origins)) {
        grid_.points[spare_] = p;
        if (cavity_.improve(star, spare_)) place = p;
      }
    }
    if (star.fresh.empty()) return;
    grid_.points[spare_] = place;
    const bool taken = star.fresh.front()[3] == spare_;
    for (const std::uint32_t t : fill(grid_, star)) enqueue(t);
    if (taken) spare_ = grid_.add_point({});
  }

  /// Vertices of the tets that share a vertex with this one.
  void list_nearby(std::uint32_t tet) {
    nearby_.clear();
    for (const std::uint32_t v : Tet4(grid_.tets[tet].v)) {
      grid_.ball(v, ball_);
      if (ball_.size() > kLargeBall) ball_.resize(kLargeBall);
      for (const std::uint32_t t : ball_)
        nearby_.insert(nearby_.end(), grid_.tets[t].v.begin(), grid_.tets[t].v.end());
    }
    std::sort(nearby_.begin(), nearby_.end());
    nearby_.erase(std::unique(nearby_.begin(), nearby_.end()), nearby_.end());
  }

  /// From the middle of the tet (one origin), or its edges' too (seven), along the normals of its faces.
  std::vector<Point> places(std::uint32_t tet, std::size_t origins) const {
    const Tet4& v = grid_.tets[tet].v;
    const auto& p = grid_.points;
    std::vector<Point> result, from = {0.25 * (p[v[0]] + p[v[1]] + p[v[2]] + p[v[3]])};
    for (const auto& e : kTetEdges) from.push_back(midpoint(p[v[e[0]]], p[v[e[1]]]));
    from.resize(origins);
    for (const auto& f : kTetFaces) {
      const Vec u = p[v[f[1]]] - p[v[f[0]]], w = p[v[f[2]]] - p[v[f[0]]];
      const Vec normal = cross(u, w);
      if (norm(normal) == 0) continue;
      const double size = std::sqrt(std::max({norm2(u), norm2(w), norm2(u - w)})) / norm(normal);
      for (const Point& origin : from)
        for (double step = 0.5; step > 1e-3; step *= 0.5)
          for (const double sign : {1.0, -1.0}) result.push_back(origin + (sign * step * size) * normal);
    }
    return result;
  }

  static constexpr std::size_t kLargeBall = 100;
  TetGrid& grid_;
  StarCavity cavity_;
  std::priority_queue<Poor> queue_;
  std::vector<std::uint32_t> nearby_, ball_;
  std::uint32_t spare_ = kNothing;
};

}  // namespace

void improve_tets(TetGrid& grid) { Improvement(grid).run(); }

}  // namespace weft::meshing
