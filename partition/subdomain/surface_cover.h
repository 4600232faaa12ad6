// Which pieces of the surface a part of a mesh is to have.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/point.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_piece.h"
#include "partition/subdomain/shared_pieces.h"
#include "partition/subdomain/subdomain.h"
#include "partition/subdomain/subdomain_start.h"

namespace weft::partition {

/// Collects the pieces that vertices have hints in, and those with anything near a boundary face: within half
/// its diameter of it, box to box. That is more than projections of the face's points and of its edges' ask
/// for, whose way begins at the face's vertices; should one lead farther, it ends at the border of what is
/// there.
class SurfaceCover {
 public:
  struct Vertex {
    meshing::Point x;
    std::uint32_t hint;
  };
  void add(const Vertex& v);
  /// A face with a vertex that has no hint lies in a plane, and asks for nothing.
  void add_face(const Vertex& a, const Vertex& b, const Vertex& c);

  /// Once all have been added.
  void finish();
  bool wants(const meshing::SurfacePiece& piece) const;
  /// False where it does not want the piece of this id and box whatever is in it.
  bool may_want(std::uint32_t id, const meshing::Box& box) const;
  /// Those of them that it wants.
  std::vector<meshing::SurfacePieces::Piece> pieces(const meshing::SurfacePieces& there) const;

 private:
  std::vector<std::uint32_t> ids_;
  std::vector<meshing::Box> near_;
  meshing::Box all_near_;
};

/// Gives back the pieces that are no longer near the subdomain's mesh.
void drop_far_surface(Subdomain& subdomain);

/// Puts the rank's copies in the place of these.
void share_surface(meshing::SurfacePieces& pieces, SharedPieces<meshing::SurfacePiece>& of_rank);

/// What a start's vertices, hints, tets and boundary faces ask for.
SurfaceCover cover_of(const SubdomainStart& start);

}  // namespace weft::partition
