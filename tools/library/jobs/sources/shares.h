// Every rank's share of a file: read by each where ranges of it can be read, else by rank 0, which deals it
// out.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "meshing/io/mesh_file.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "weft/weft.h"

namespace weft::tools {

/// Of so many entities those of one rank.
struct Share {
  std::uint64_t first, count;
};
Share share_of(std::uint64_t total, int rank, int ranks);

struct MeshShare {
  partition::MeshSlice slice;    ///< without metric
  meshing::RefNames names;       ///< on rank 0 at least
  std::vector<Dropped> dropped;  ///< likewise: what of the file has no place here
  bool read_whole = false;       ///< by rank 0: the same on all ranks
};
/// Fields of a mesh file at the points of a slice.
struct FieldsShare {
  Fields fields;
  std::uint64_t num_points = 0;  ///< of the whole mesh
  std::vector<Dropped> dropped;  ///< on rank 0 at least: what is no field here
};

/// All ranks: the share of a mesh file. Throws InputError alike on all ranks.
MeshShare read_mesh_share(partition::Peers& peers, const std::string& file,
                          meshing::OtherVolumes others = meshing::OtherVolumes::refused);

/// Whether the fields in a mesh file are read in shares.
bool has_own_fields_in_shares(const std::string& file);
/// All ranks: those, at the points of the shares of the mesh; none where it has none. Throws InputError alike
/// on all ranks.
FieldsShare read_own_fields_share(partition::Peers& peers, const std::string& file);

/// All ranks: the fields of a file at the points of the slice of a mesh: GMF, VTK and CGNS in ranges, of
/// .msh rank 0 deals them out as it reads, of others whole. Throws InputError alike on all ranks, with
/// of_another_mesh(its vertices) as the reason where it has another number of vertices than the mesh.
Fields read_fields_share(partition::Peers& peers, const std::string& file, const partition::MeshSlice& slice,
                         const std::function<std::string(std::uint64_t)>& of_another_mesh);

/// All ranks: triangles, edges and marks of a mesh of rank 0, as MeshSlice has them.
void deal_boundary(partition::Peers& peers, const meshing::MeshData& mesh, partition::MeshSlice& slice);
/// All ranks: the shares of a mesh that rank 0 has whole (elsewhere `mesh` is empty), with its metric (none:
/// without).
partition::MeshSlice deal_out(partition::Peers& peers, const meshing::MeshData& mesh,
                              const meshing::LogMetricField& metric);
/// All ranks: the fields that rank 0 has, at the points of the slices.
Fields deal_fields(partition::Peers& peers, const Fields& whole, const partition::MeshSlice& slice);

/// Whether no rank holds them all in read_fields_share().
bool fields_in_shares(const std::string& file);
/// All ranks: what the whole mesh has.
meshing::ContentCounts counts_of_slices(partition::Peers& peers, const partition::MeshSlice& slice);
/// That rank 0 has held all of a file, of which `what` are not read in shares; for the user.
std::string read_whole_warning(const std::string& file, const std::string& what);

}  // namespace weft::tools
