// Shares of a mesh in pieces: of a .pvtu, or of a .vtu or .cgns with several.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "meshing/io/files/merge_pieces.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "tools/library/jobs/sources/shares.h"

namespace weft::tools {

/// What the pieces of a file are, known on all ranks, which read consecutive shares of them put one after the
/// other. Points that several have become one as meshing::merge_pieces() makes them; so do the fields that
/// all have. All functions are called by all ranks together and throw InputError alike.
class PieceShares {
 public:
  /// Of a file that meshing::can_be_in_pieces().
  PieceShares(partition::Peers& peers, const std::string& file);

  MeshShare mesh(partition::Peers& peers, meshing::OtherVolumes others) const;
  /// None where the pieces have none in common.
  FieldsShare fields(partition::Peers& peers) const;

 private:
  struct Piece {
    std::uint64_t source;  ///< which of the files has it
    meshing::MeshSize size;
    std::uint64_t first_point, first_tet;  ///< of all pieces, put one after the other
  };
  struct Copies;

  std::vector<meshing::PieceRange> ranges(Share points, Share tets, Share others) const;
  template <class Read>
  void read_sources(const std::vector<meshing::PieceRange>& ranges, bool always, const Read& read) const;
  Copies read_points(partition::Peers& peers) const;

  std::string file_;
  std::vector<std::filesystem::path> sources_;
  std::vector<Piece> pieces_;
  std::uint64_t num_points_ = 0, num_tets_ = 0;  ///< of all pieces
  bool by_ids_ = true;
  std::uint8_t not_refs_ = 0;  ///< PieceRange::not_refs
};

}  // namespace weft::tools
