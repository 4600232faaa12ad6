// Near vertices, then the faces that become one when these do.
#include "meshing/mesh/repair/close_cracks.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/number_sets.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/repair/open_faces.h"
#include "meshing/mesh/repair/point_tree.h"

namespace weft::meshing {
namespace {

class Cracks {
 public:
  explicit Cracks(const MeshData& mesh) : m_(mesh), open_(open_faces(mesh)) {}

  std::map<std::uint32_t, std::uint32_t> run() {
    if (open_.empty()) return {};
    for (const OpenFace& f : open_) vertices_.insert(vertices_.end(), f.vertices.begin(), f.vertices.end());
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    measure();
    NumberSets near(m_.points.size());
    if (!find_near(near)) return {};
    unite_at_faces(near);
    while (take_back()) {
    }
    return std::move(into_);
  }

 private:
  /// How near is near, at each vertex of open faces.
  void measure() {
    reach_.assign(m_.points.size(), 0);
    for (const std::uint32_t v : vertices_) reach_[v] = std::numeric_limits<double>::max();
    Box box;
    for (const Tet& t : m_.tets)
      for (const std::uint32_t v : t) {
        box.include(m_.points[v]);
        if (reach_[v] == 0) continue;
        for (const std::uint32_t w : t)
          if (w != v) reach_[v] = std::min(reach_[v], kNearlyThereOfEdge * norm(m_.points[w] - m_.points[v]));
      }
    const double most = kNearlyThere * norm(box.size());
    for (double& reach : reach_) reach = std::min(reach, most);
  }

  bool find_near(NumberSets& near) const {
    bool any = false;
    const PointTree tree(m_.points, vertices_);
    for (const std::uint32_t v : vertices_) {
      Box box;
      box.include(m_.points[v]);
      tree.visit_in(box.grown(reach_[v]), [&](std::uint32_t w) {
        if (w <= v || norm(m_.points[w] - m_.points[v]) > std::min(reach_[v], reach_[w])) return;
        near.unite(v, w);
        any = true;
      });
    }
    return any;
  }

  struct Side {
    Triangle becomes;   ///< ascending
    Triangle vertices;  ///< in the same order
    int apex_side;
  };

  /// Of vertices that are near each other only those become one of which faces do.
  void unite_at_faces(NumberSets& near) {
    std::vector<Side> sides;
    for (const OpenFace& f : open_) sides.push_back(side_of(f, near));
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::tie(a.becomes, a.vertices) < std::tie(b.becomes, b.vertices);
    });
    NumberSets one(m_.points.size());
    for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
      while (end < sides.size() && sides[end].becomes == sides[i].becomes) ++end;
      if (end - i != 2 || sides[i].apex_side * sides[i + 1].apex_side >= 0) continue;
      for (std::size_t k = 0; k < 3; ++k) one.unite(sides[i].vertices[k], sides[i + 1].vertices[k]);
    }
    for (const std::uint32_t v : vertices_)
      if (one.of(v) != v) into_[v] = one.of(v);
  }

  Side side_of(const OpenFace& f, NumberSets& near) const {
    std::array<std::pair<std::uint32_t, std::uint32_t>, 3> both;
    for (std::size_t k = 0; k < 3; ++k) both[k] = {near.of(f.vertices[k]), f.vertices[k]};
    std::sort(both.begin(), both.end());
    Side side{};
    for (std::size_t k = 0; k < 3; ++k) std::tie(side.becomes[k], side.vertices[k]) = both[k];
    const Triangle& v = side.vertices;
    side.apex_side = orientation(m_.points[v[0]], m_.points[v[1]], m_.points[v[2]],
                                 m_.points[m_.tets[f.code >> 2][f.code & 3]]);
    return side;
  }

  /// What must stay, as a tet would be turned over, or lose its volume; whether there was any.
  bool take_back() {
    std::set<std::uint32_t> staying;
    for (const Tet& t : m_.tets) {
      Tet now = t;
      for (std::uint32_t& v : now)
        if (const auto found = into_.find(v); found != into_.end()) v = found->second;
      if (now == t || sign_of(now) == sign_of(t)) continue;
      for (std::size_t k = 0; k < 4; ++k)
        if (now[k] != t[k]) staying.insert(now[k]);
    }
    std::erase_if(into_, [&](const auto& merge) { return staying.contains(merge.second); });
    return !staying.empty();
  }
  int sign_of(const Tet& t) const {
    return orientation(m_.points[t[0]], m_.points[t[1]], m_.points[t[2]], m_.points[t[3]]);
  }

  const MeshData& m_;
  std::vector<OpenFace> open_;
  std::vector<std::uint32_t> vertices_;  ///< of open faces
  std::vector<double> reach_;
  std::map<std::uint32_t, std::uint32_t> into_;
};

}  // namespace

std::map<std::uint32_t, std::uint32_t> cracks_to_close(const MeshData& mesh) { return Cracks(mesh).run(); }

}  // namespace weft::meshing
