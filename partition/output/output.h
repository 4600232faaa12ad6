// Writes the result of all subdomains, by all ranks at once and without gathering it.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "meshing/io/files/mesh_contents.h"
#include "partition/communication/peers.h"
#include "partition/output/numbering.h"
#include "partition/output/piece_fields.h"
#include "partition/subdomain/mesh_piece.h"

namespace weft::partition {

/// Whether write_pieces() can write such a file.
bool can_write_pieces(const std::filesystem::path& mesh);

/// The result on its way into files: bytes can go out while it is measured. All ranks make one, which creates
/// one GMF file, or one that can be written in parts (meshing::can_be_written_in_parts,
/// can_be_written_as_text), with metrics and fields inside where its format holds fields, and beside it one
/// .solb or .sol of the metrics unless `solution` is empty, and one of the fields. The bytes are those that
/// write_mesh_contents and write_gmf_solution would write for merge_pieces() of all pieces, whatever rank has
/// which. Each rank writes its part into a temporary file beside the target, which all ranks must see, or
/// hands it to one that does (Peers::most_writers). Each rank makes its rows of text twice, for their length
/// and to write them. `carried`, of rank 0: the CAD model to be in the file, as bytes. `version`: of GMF, 0
/// chooses (write_gmf_mesh). `names`, of rank 0: those of references. `numbering`: of these pieces. What is
/// given must outlive the object. When any rank fails all throw the same meshing::InputError. Where it goes
/// without finish() nothing is left.
class PiecesOutput {
 public:
  PiecesOutput(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering,
               const std::filesystem::path& mesh, const std::filesystem::path& solution,
               const meshing::Association& carried, int version, const meshing::RefNames& names,
               const PieceFields& fields);
  ~PiecesOutput();

  /// This rank's part; asks no other rank. In any thread, in its TBB arena. What fails is told by finish().
  void write() noexcept;
  /// All ranks, when write() has ended: the files appear, renamed by rank 0 once all ranks have succeeded.
  void finish(Peers& peers);

 private:
  struct Files;
  std::unique_ptr<Files> files_;
};

/// All ranks: PiecesOutput, at once.
void write_pieces(Peers& peers, std::span<const MeshPiece> mine, const std::filesystem::path& mesh,
                  const std::filesystem::path& solution = {}, const meshing::Association& carried = {},
                  int version = 0, const meshing::RefNames& names = {}, const PieceFields& fields = {});

}  // namespace weft::partition
