// A Steiner point's cavity grows beyond faces that the point does not see: slivers in its way go with them.
#include "meshing/initial/recovery/insert_steiner.h"

#include <algorithm>
#include <unordered_set>

namespace weft::meshing {
namespace {

class SteinerCavity {
 public:
  SteinerCavity(Recovery& r, std::span<const std::uint32_t> seed, std::uint32_t v)
      : r_(r), grid_(r.grid), v_(v), cavity_(seed.begin(), seed.end()) {}

  /// `solid`: makes no slivers.
  bool fill(bool solid) {
    solid_ = solid;
    if (!grow() || !keeps_all()) return false;
    grid_.replace(cavity_, fresh_);
    return true;
  }

 private:
  static constexpr std::size_t kMostTets = 300;

  bool inside(std::uint32_t t) const { return std::find(cavity_.begin(), cavity_.end(), t) != cavity_.end(); }

  bool grow() {
    for (bool grown = true; grown;) {
      grown = false;
      fresh_.clear();
      for (std::size_t i = 0; i < cavity_.size(); ++i)
        for (int f = 0; f < 4; ++f) {
          const TetGrid::Tet& tet = grid_.tets[cavity_[i]];
          if (tet.n[f] != kNothing && inside(tet.n[f] >> 2)) {
            if (tet.facet[f] != kNothing) return false;
            continue;
          }
          const Face3 w = grid_.face(cavity_[i], f);
          fresh_.push_back({w[0], w[1], w[2], v_});
          if (grid_.positive(fresh_.back()) && !(solid_ && grid_.sliver(fresh_.back()))) continue;
          if (tet.n[f] == kNothing || tet.facet[f] != kNothing || cavity_.size() >= kMostTets) return false;
          cavity_.push_back(tet.n[f] >> 2);
          grown = true;
        }
    }
    return true;
  }

  /// No vertex and no part of an input edge may vanish in the cavity.
  bool keeps_all() const {
    std::unordered_set<std::uint32_t> vertices;
    std::unordered_set<std::uint64_t> edges;
    for (const Tet4& t : fresh_)
      for (std::size_t i = 0; i < 3; ++i) {
        vertices.insert(t[i]);
        edges.insert(Recovery::key(t[i], t[(i + 1) % 3]));
      }
    for (const std::uint32_t t : cavity_) {
      const Tet4& w = grid_.tets[t].v;
      for (const std::uint32_t v : w)
        if (!vertices.contains(v)) return false;
      for (const auto& e : kTetEdges) {
        const std::uint64_t edge = Recovery::key(w[e[0]], w[e[1]]);
        if (!edges.contains(edge) && r_.edge_at.contains(edge)) return false;
      }
    }
    return true;
  }

  Recovery& r_;
  TetGrid& grid_;
  std::uint32_t v_;
  std::vector<std::uint32_t> cavity_;
  std::vector<Tet4> fresh_;
  bool solid_ = true;
};

}  // namespace

bool insert_steiner(Recovery& r, std::span<const std::uint32_t> seed, std::uint32_t v) {
  return SteinerCavity(r, seed, v).fill(true) || SteinerCavity(r, seed, v).fill(false);
}

}  // namespace weft::meshing
