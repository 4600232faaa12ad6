// Files of what lies in slices, written by all ranks at once.
#pragma once

#include <filesystem>

#include "meshing/io/files/mesh_contents.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// All ranks: one .solb or .sol of fields at the points of the slices, of the same kinds on all ranks; the
/// bytes are those of meshing::write_solution with all of them. It appears when all have written; when any
/// rank fails all throw the same meshing::InputError and nothing is left. Other extensions are refused.
void write_fields_of_slices(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                            const std::filesystem::path& file);

/// Whether write_mesh_of_slices() can write such a file.
bool can_write_slices(const std::filesystem::path& mesh, const meshing::WriteOptions& options = {});

/// All ranks: a GMF file, or one that can be written in parts (meshing::can_be_written_in_parts, or
/// can_be_written_as_text, can_be_written_in_blocks), of the mesh of the slices, with `fields` at their
/// points inside where its format holds fields; the bytes are those of meshing::write_mesh_contents with the
/// whole mesh. `names`, of rank 0: those of references. It appears as the fields do.
void write_mesh_of_slices(Peers& peers, const MeshSlice& slice, const meshing::SolutionData& fields,
                          const meshing::RefNames& names, const std::filesystem::path& file,
                          const meshing::WriteOptions& options = {});

}  // namespace weft::partition
