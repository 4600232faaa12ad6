#include "meshing/initial/mending/close_openings.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <set>

#include "meshing/initial/grid/delaunay.h"
#include "meshing/initial/mending/winding_number.h"
#include "meshing/initial/recovery/recover_edges.h"
#include "meshing/initial/recovery/recover_facets.h"
#include "meshing/initial/recovery/recovery.h"
#include "meshing/initial/recovery/remove_slivers.h"

namespace weft::meshing {
namespace {

class Closing {
 public:
  Closing(const std::vector<Point>& points, const LooseTriangles& triangles,
          std::span<const std::uint32_t> numbers, const std::atomic<bool>* interrupt)
      : points_(points), triangles_(triangles), interrupt_(interrupt) {
    r_.source = numbers;
  }

  ClosedOpenings run() {
    make_grid();
    decide();
    smooth();
    choose_faces();
    return write();
  }

 private:
  void make_grid() {
    std::vector<std::uint32_t> number(points_.size(), kNothing);
    std::vector<Point> used;
    for (Triangle t : triangles_.corners) {
      for (std::uint32_t& v : t) {
        if (number[v] == kNothing) {
          number[v] = static_cast<std::uint32_t>(used.size());
          used.push_back(points_[v]);
          given_.push_back(v);
        }
        v = number[v];
      }
      r_.facets.push_back(t);
    }
    r_.grid = delaunay_in_box(used, interrupt_);
    remove_slivers(r_);
    list_input_edges(r_);
    recover_edges(r_);
    recover_facets(r_);
  }

  Point middle(std::uint32_t t) const {
    Point sum;
    for (const std::uint32_t v : grid_.tets[t].v) sum += 0.25 * grid_.points[v];
    return sum;
  }

  /// By the facets of a tet: 1 inside, -1 outside, 0 if they do not say or contradict each other.
  int by_facets(std::uint32_t t) const {
    bool in = false, out = false;
    for (std::uint32_t f = 0; f < 4; ++f) {
      const std::uint32_t facet = grid_.tets[t].facet[f];
      if (facet == kNothing) continue;
      const Face3& w = r_.facets[facet];
      const int side = grid_.orient(w[0], w[1], w[2], grid_.tets[t].v[f]);
      in |= side < 0;
      out |= side > 0;
    }
    return int{in} - int{out};
  }

  void decide() {
    const WindingNumber winding(points_, triangles_.corners, triangles_.sheets);
    value_.assign(grid_.tets.size(), 0);
    certain_.assign(grid_.tets.size(), 0);
    tbb::parallel_for(0u, static_cast<std::uint32_t>(grid_.tets.size()), [&](std::uint32_t t) {
      if (!grid_.alive(t)) return;
      const int known = by_facets(t);
      certain_[t] = known != 0;
      value_[t] = known != 0 ? 0.5 * (1 + known) : winding.at(middle(t));
    });
    inside_.resize(value_.size());
    for (std::size_t t = 0; t < value_.size(); ++t) inside_[t] = value_[t] > 0.5;
  }

  /// Tets on whose sides most faces say otherwise follow them, where the winding number is near to doubt: it
  /// takes the teeth from the closing faces.
  void smooth() {
    constexpr int kMostRounds = 10;
    constexpr double kDoubt = 0.25;
    for (int round = 0; round < kMostRounds; ++round) {
      std::size_t changed = 0;
      for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) {
        if (!grid_.alive(t) || certain_[t] || std::abs(value_[t] - 0.5) > kDoubt) continue;
        double same = 0, other = 0;
        for (std::uint32_t f = 0; f < 4; ++f) {
          const std::uint32_t n = grid_.tets[t].n[f];
          if (grid_.tets[t].facet[f] != kNothing) continue;
          const bool in = n != kNothing && inside_[n >> 2];
          (in == inside_[t] ? same : other) += area(grid_.face(t, static_cast<int>(f)));
        }
        if (other <= same) continue;
        inside_[t] = !inside_[t];
        ++changed;
      }
      if (changed == 0) return;
    }
  }

  double area(const Triangle& w) const {
    const auto& p = grid_.points;
    return norm(cross(p[w[1]] - p[w[0]], p[w[2]] - p[w[0]]));
  }

  bool is_outside(std::uint32_t code) const { return code == kNothing || !inside_[code >> 2]; }

  /// Faces between inside and outside, by the facet that they are a piece of.
  void choose_faces() {
    pieces_.resize(r_.facets.size());
    for (std::uint32_t t = 0; t < grid_.tets.size(); ++t) {
      if (!grid_.alive(t) || !inside_[t]) continue;
      for (std::uint32_t f = 0; f < 4; ++f) {
        if (!is_outside(grid_.tets[t].n[f])) continue;
        const Face3 w = grid_.face(t, static_cast<int>(f));
        const std::uint32_t facet = grid_.tets[t].facet[f];
        (facet == kNothing ? fresh_ : pieces_[facet]).push_back({w[0], w[2], w[1]});
      }
    }
  }

  bool is_steiner(std::uint32_t v) const { return v >= given_.size(); }

  /// Facets are left whole unless Steiner points in them or on their edges are vertices of the closing faces,
  /// or of facets that are in pieces for that.
  std::vector<bool> facets_in_pieces() const {
    std::set<std::uint32_t> used;
    for (const Triangle& w : fresh_)
      for (const std::uint32_t v : w)
        if (is_steiner(v)) used.insert(v);
    std::vector<bool> cut(pieces_.size());
    for (bool more = !used.empty(); more;) {
      more = false;
      for (std::size_t i = 0; i < pieces_.size(); ++i) {
        const auto holds = [&](const Triangle& w) {
          return std::any_of(w.begin(), w.end(), [&](std::uint32_t v) { return used.contains(v); });
        };
        if (cut[i] || !std::any_of(pieces_[i].begin(), pieces_[i].end(), holds)) continue;
        cut[i] = more = true;
        for (const Triangle& w : pieces_[i])
          for (const std::uint32_t v : w)
            if (is_steiner(v)) used.insert(v);
      }
    }
    return cut;
  }

  ClosedOpenings write() {
    ClosedOpenings result;
    result.points = points_;
    const std::vector<bool> cut = facets_in_pieces();
    for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
      if (pieces_[i].empty()) continue;
      if (cut[i])
        for (const Triangle& w : pieces_[i]) add(renumbered(w, result.points), i, false, result);
      else
        add(triangles_.corners[i], i, false, result);
    }
    add_fresh(result);
    list_cuts(result.cuts);
    return result;
  }

  /// Edges of facets that are in pieces.
  void list_cuts(EdgeCuts& cuts) const {
    for (const InputEdge& edge : r_.edges) {
      std::vector<std::uint32_t> vertices;
      for (const std::uint32_t v : edge.chain)
        if (const auto at = steiner_.find(v); at != steiner_.end()) vertices.push_back(at->second);
      if (vertices.empty()) continue;
      const std::uint32_t a = given_[edge.a], b = given_[edge.b];
      if (a > b) std::reverse(vertices.begin(), vertices.end());
      cuts.emplace(edge_key(a, b), std::move(vertices));
    }
  }

  void add(const Triangle& w, std::uint32_t beside, bool is_new, ClosedOpenings& result) const {
    result.triangles.corners.push_back(w);
    result.triangles.refs.push_back(triangles_.refs[beside]);
    result.triangles.source.push_back(triangles_.source[beside]);
    result.triangles.sheets.push_back(1);
    result.closing.push_back(is_new);
  }

  Triangle renumbered(Triangle w, std::vector<Point>& points) {
    for (std::uint32_t& v : w) {
      if (!is_steiner(v)) {
        v = given_[v];
        continue;
      }
      const auto [at, is_new] = steiner_.try_emplace(v, static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back(grid_.points[v]);
      v = at->second;
    }
    return w;
  }

  /// Closing faces take the reference of what is beside them, from the openings' borders inwards.
  void add_fresh(ClosedOpenings& result) {
    std::unordered_map<std::uint64_t, std::uint32_t> beside;  // edge -> facet
    for (std::uint32_t i = 0; i < pieces_.size(); ++i)
      for (const Triangle& w : pieces_[i])
        for (std::size_t k = 0; k < 3; ++k) beside.try_emplace(edge_key(w[k], w[(k + 1) % 3]), i);
    std::vector<Triangle> left = fresh_;
    for (bool more = true; !left.empty();) {
      std::vector<Triangle> later;
      for (const Triangle& w : left) {
        std::uint32_t facet = more ? kNothing : 0;
        for (std::size_t k = 0; k < 3 && facet == kNothing; ++k) {
          const auto at = beside.find(edge_key(w[k], w[(k + 1) % 3]));
          if (at != beside.end()) facet = at->second;
        }
        if (facet == kNothing) {
          later.push_back(w);
          continue;
        }
        for (std::size_t k = 0; k < 3; ++k) beside.try_emplace(edge_key(w[k], w[(k + 1) % 3]), facet);
        add(renumbered(w, result.points), facet, true, result);
      }
      more = later.size() < left.size();
      left = std::move(later);
    }
  }

  const std::vector<Point>& points_;
  const LooseTriangles& triangles_;
  const std::atomic<bool>* interrupt_;
  Recovery r_;
  TetGrid& grid_ = r_.grid;
  std::vector<std::uint32_t> given_;  ///< of each point of the grid that is no Steiner point: the given one
  std::vector<double> value_;         ///< of each tet: its winding number
  std::vector<char> certain_, inside_;
  std::vector<std::vector<Triangle>> pieces_;  ///< of each facet
  std::vector<Triangle> fresh_;
  std::unordered_map<std::uint32_t, std::uint32_t> steiner_;
};

}  // namespace

ClosedOpenings close_openings(const std::vector<Point>& points, const LooseTriangles& triangles,
                              std::span<const std::uint32_t> numbers, const std::atomic<bool>* interrupt) {
  return Closing(points, triangles, numbers, interrupt).run();
}

}  // namespace weft::meshing
