// A cavity that is filled from one vertex and grows, short of the facets, until every tet is good enough.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/initial/grid/tet_grid.h"

namespace weft::meshing {

/// The tets of a cavity filled from one vertex.
struct Star {
  std::vector<std::uint32_t> old;  ///< the cavity
  std::vector<Tet4> fresh;         ///< what fills it; the vertex comes last
  double worst = 0;                ///< the least TetGrid::shape of `fresh`; 0: there is no star
};

/// Facet faces are walls that it neither crosses nor takes away. Vertices that are on none may be lost in it.
class StarCavity {
 public:
  explicit StarCavity(TetGrid& grid) : grid_(grid) {}

  /// Where cavities start: the tets of a vertex that gives way, on one side of the facets it is on, if it is
  /// on any; `lids` close them instead of the facets' faces at the vertex, seen from their positive sides.
  /// They do not grow into `blocked`. The spans must live as long as the cavity is used.
  void begin(std::uint32_t vertex, std::span<const std::uint32_t> tets, std::span<const Face3> lids,
             std::span<const std::uint32_t> blocked);

  /// Whether filling from v, all of whose tets are better than `star`, replaces it. Faces whose tet would not
  /// be better are passed.
  bool improve(Star& star, std::uint32_t v);

 private:
  static constexpr std::size_t kMostTets = 1000;
  struct Wall {
    Tet4 tet;              ///< the face and the star's vertex
    std::uint32_t beyond;  ///< code of the neighbour's face
    double shape;
  };
  bool take(std::uint32_t v, double limit);
  bool take_tet(std::uint32_t t, std::uint32_t v, double limit);
  bool pass(std::uint32_t t, int face);
  void include(std::uint32_t t);
  bool inside(std::uint32_t t) const { return t < stamps_.size() && stamps_[t] == stamp_; }

  TetGrid& grid_;
  std::uint32_t vertex_ = kNothing;
  std::span<const std::uint32_t> seed_, blocked_;
  std::span<const Face3> lids_;
  std::vector<std::uint32_t> cavity_, stamps_;
  std::uint32_t stamp_ = 0;
  std::vector<Wall> walls_;
};

/// Exchanges the cavity for the star. `facets` marks faces of its tets. Returns their numbers, valid until
/// the next exchange.
std::span<const std::uint32_t> fill(TetGrid& grid, const Star& star, std::span<const FacetFace> facets = {});

}  // namespace weft::meshing
