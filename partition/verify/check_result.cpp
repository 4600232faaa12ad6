// Sums of faces over all pieces.
#include "partition/verify/check_result.h"

#include <cstdint>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/geometry/surface/face_directions.h"
#include "meshing/mesh/face_sums.h"
#include "partition/communication/reduce.h"
#include "partition/verify/check_pieces.h"
#include "partition/verify/check_subdomains.h"

namespace weft::partition {
namespace {

meshing::FaceSums sums_of(const MeshPiece& piece) {
  std::vector<std::uint64_t> ids;
  ids.reserve(piece.ids.size());
  for (const GlobalId id : piece.ids) ids.push_back(id.value());
  meshing::FaceSums sums = meshing::sum_faces(piece.mesh, ids);
  if (meshing::may_curve(piece.mesh)) sums.faults += meshing::crowded_sides(piece.mesh);
  return sums;
}

}  // namespace

bool conforms(Peers& peers, std::span<const MeshPiece> mine) {
  std::vector<meshing::FaceSums> of_pieces(mine.size());
  meshing::for_each_large(mine.size(), [&](std::size_t p) { of_pieces[p] = sums_of(mine[p]); });
  meshing::FaceSums sums;
  for (const meshing::FaceSums& of_piece : of_pieces) sums += of_piece;
  const std::vector<std::uint64_t> all = sum(peers, std::vector{sums.faults, sums.faces, sums.references});
  return meshing::FaceSums{all[0], all[1], all[2]}.ok();
}

void check_result(Peers& peers, std::span<const MeshPiece> mine) {
  if (conforms(peers, mine)) return;
  PiecesReport report = check_pieces(peers, mine);
  if (report.ok()) {
    report.num_problems = 1;
    report.problems = {"faces of tets do not match, and none can be named"};
  }
  throw_if_violated(report, "in the result");
}

}  // namespace weft::partition
