// A .pvtu of what lies in slices: some ranks write a piece each.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// All ranks: the mesh of the slices, with fields at their points of the same kinds on all ranks, in
/// options.pieces pieces (at least one), which are dealt to the ranks; the bytes are those of
/// meshing::write_pvtu() with the whole mesh. A rank holds one piece at a time. The index appears when all
/// pieces have been written; when any rank fails all throw the same meshing::InputError and nothing is left.
void write_slices_as_pvtu(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                          const std::filesystem::path& file, const meshing::WriteOptions& options);

}  // namespace weft::partition
