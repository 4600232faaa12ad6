// The tets that an initial mesh grows in: plain vectors, one thread, one way to change them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/initial/grid/exact_place.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::meshing {

inline constexpr std::uint32_t kNothing = 0xFFFFFFFFu;

using Tet4 = std::array<std::uint32_t, 4>;
using Face3 = std::array<std::uint32_t, 3>;

/// A face that is a piece of an input triangle.
struct FacetFace {
  Face3 vertices;
  std::uint32_t facet;
};

/// A conforming set of positive tets. Faces are coded 4 * tet + face, as in Adjacency.
class TetGrid {
 public:
  struct Tet {
    Tet4 v{0, 0, 0, 0};                              ///< all zero: dead
    Tet4 n{kNothing, kNothing, kNothing, kNothing};  ///< codes of the neighbours' faces
    std::array<std::uint32_t, 4> facet{kNothing, kNothing, kNothing, kNothing};  ///< input triangle on a face
  };
  /// The tets around an edge in positive order: tet i is (a, b, ring[i], ring[i + 1]). Closed when the last
  /// one meets the first; else ring has one more vertex than there are tets.
  struct EdgeShell {
    std::vector<std::uint32_t> tets, ring;
    bool closed = false;
  };

  std::vector<Point> points;
  std::vector<Tet> tets;
  std::vector<std::uint32_t> vertex_tet;         ///< of each point: one tet that holds it, kNothing without
  const std::atomic<bool>* interrupt = nullptr;  ///< once set, replace() throws Interrupted

  std::uint32_t add_point(const Point& p);
  /// Puts point v where doubles cannot: `points` has it rounded, orient() takes it exactly. move() ends that.
  void place_exactly(std::uint32_t v, const ExactPlace& place);
  void move(std::uint32_t v, const Point& p);
  /// Where v is, exactly.
  ExactPlace place(std::uint32_t v) const;
  bool alive(std::uint32_t t) const { return tets[t].v[0] != tets[t].v[1]; }
  int orient(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const;
  int orient(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Point& d) const;
  bool positive(const Tet4& v) const { return orient(v[0], v[1], v[2], v[3]) > 0; }
  /// Six times the volume over (sum of squared edges)^1.5; 0 for a tet that is not positive exactly.
  double shape(const Tet4& v) const;
  /// The same where it is above `enough`, else 0, without exact arithmetic unless that is needed to tell.
  double shape_above(const Tet4& v, double enough) const;
  /// Whether the tet is flatter than 1e-9 of its shortest edge.
  bool sliver(const Tet4& v) const;
  /// Vertices of a face, its tet on their positive side.
  Face3 face(std::uint32_t t, int f) const {
    const Tet4& v = tets[t].v;
    return {v[kTetFaces[f][0]], v[kTetFaces[f][1]], v[kTetFaces[f][2]]};
  }
  int local_index(std::uint32_t t, std::uint32_t v) const;  ///< -1 when v is no vertex of t

  /// Exchanges tets for others that fill the same space and glues them. Marks of outer faces are kept, those
  /// between the old tets go; `facets` marks faces of the fresh tets. Returns the fresh tets' numbers, valid
  /// until the next call.
  std::span<const std::uint32_t> replace(std::span<const std::uint32_t> old, std::span<const Tet4> fresh,
                                         std::span<const FacetFace> facets = {});
  /// Whether v sees all outer faces of the cavity strictly; fills `fresh` with the tets to v.
  bool star(std::span<const std::uint32_t> cavity, std::uint32_t v, std::vector<Tet4>& fresh);
  /// The same as replace() for what star() has just filled, without a search for what is glued to what.
  std::span<const std::uint32_t> fill_star(std::span<const std::uint32_t> cavity,
                                           std::span<const Tet4> fresh);
  void remove(std::uint32_t t);
  void set_facet(std::uint32_t t, int f, std::uint32_t facet);

  /// All tets that hold v.
  void ball(std::uint32_t v, std::vector<std::uint32_t>& out);
  /// A tet that holds both, or kNothing.
  std::uint32_t tet_with_edge(std::uint32_t a, std::uint32_t b);
  /// The shell of an edge that `tet` holds.
  void shell(std::uint32_t tet, std::uint32_t a, std::uint32_t b, EdgeShell& out) const;

 private:
  struct Side {
    Face3 key;
    std::uint32_t code, facet;
    bool outer;
  };
  /// What lies beyond an outer face of a star's cavity.
  struct Beyond {
    std::uint32_t code, facet;
  };
  /// A face of a star's tet at the star's vertex, known by the edge opposite, that waits for the other side.
  struct Spoke {
    std::uint64_t edge;
    std::uint32_t code, stamp;
  };
  std::uint32_t take_slot();
  void glue_spoke(std::uint32_t u, std::uint32_t w, std::uint32_t code);
  void collect_outer(std::span<const std::uint32_t> old);
  void collect_fresh(std::span<const std::uint32_t> slots);
  void glue_sides();
  void begin_marking() { marks_.resize(tets.size(), 0), ++stamp_; }
  bool mark(std::uint32_t t) { return marks_[t] != stamp_ && (marks_[t] = stamp_, true); }
  bool marked(std::uint32_t t) const { return marks_[t] == stamp_; }

  bool is_exact(std::uint32_t v) const { return v < exact_.size() && exact_[v] != kNothing; }

  std::vector<std::uint32_t>
      exact_;  ///< of each point: its number in places_, kNothing or beyond for plain ones
  std::vector<ExactPlace> places_;
  std::vector<std::uint32_t> free_, slots_, around_;
  std::vector<Side> sides_;
  std::vector<Beyond> beyond_;  ///< of the star that star() looked at last
  std::vector<Spoke> spokes_;   ///< a hash table, of a power of two
  std::uint32_t spoke_stamp_ = 0;
  std::vector<std::uint32_t> marks_;
  std::uint32_t stamp_ = 0;
};

/// A face's vertices in ascending order.
Face3 face_key(const Face3& f);

/// Numbers the volumes that facets divide, in the order of their first tets: one number for every tet.
std::vector<std::uint32_t> flood_regions(const TetGrid& grid, std::uint32_t& count);

}  // namespace weft::meshing
