// One file a piece, through meshing's writers.
#include "partition/output/piece_files.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <list>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/io/mesh_file.h"
#include "meshing/io/vtk/pvtu.h"
#include "meshing/io/vtk/vtu.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/agreement.h"
#include "partition/output/numbering.h"
#include "partition/output/whole_mesh.h"

namespace weft::partition {
namespace {

namespace fs = std::filesystem;
using meshing::MeshData;

// --- VTU

template <std::size_t N>
void take_own(const std::vector<std::array<std::uint32_t, N>>& entities,
              const std::vector<std::int32_t>& refs, const std::vector<std::uint8_t>& own,
              std::vector<std::array<std::uint32_t, N>>& taken, std::vector<std::int32_t>& taken_refs) {
  for (std::size_t e = 0; e < entities.size(); ++e) {
    if (!own[e]) continue;
    taken.push_back(entities[e]);
    taken_refs.push_back(refs[e]);
  }
}

/// All points and tets of a piece; of the rest what is its own.
MeshData visible_part(const MeshPiece& piece, const PieceShare& share) {
  const MeshData& mesh = piece.mesh;
  MeshData part;
  part.points = mesh.points;
  part.point_refs = mesh.point_refs;
  part.tets = mesh.tets;
  part.tet_refs = mesh.tet_refs;
  take_own(mesh.triangles, mesh.triangle_refs, share.triangles, part.triangles, part.triangle_refs);
  take_own(mesh.edges, mesh.edge_refs, share.edges, part.edges, part.edge_refs);
  for (std::size_t i = 0; i < mesh.corners.size(); ++i)
    if (share.corners[i]) part.corners.push_back(mesh.corners[i]);
  return part;
}

std::vector<meshing::CellData> cell_data(const MeshPiece& piece, const MeshData& part) {
  const std::size_t cells =
      part.tets.size() + part.triangles.size() + part.edges.size() + part.corners.size();
  std::vector<double> quality(cells, std::numeric_limits<double>::quiet_NaN());
  const auto& p = part.points;
  const auto& l = piece.log_metrics;
  for (std::size_t t = 0; t < part.tets.size(); ++t) {
    const auto& [a, b, c, d] = part.tets[t];
    quality[t] = meshing::mean_ratio({p[a], p[b], p[c], p[d]}, {l[a], l[b], l[c], l[d]});
  }
  return {{"subdomain", std::vector<double>(cells, piece.subdomain.value)}, {"quality", std::move(quality)}};
}

std::string vtu_name(const fs::path& index, SubdomainId subdomain) {
  return index.stem().string() + "_" + std::to_string(subdomain.value) + ".vtu";
}

/// The kinds and names of metric and fields.
meshing::SolutionData kinds_of(const PieceFields& fields) {
  meshing::SolutionData kinds = meshing::solution_from_metric({});
  std::ranges::copy(fields.kinds.fields, std::back_inserter(kinds.fields));
  return kinds;
}

void write_vtu(const fs::path& path, const MeshPiece& piece, const PieceNumbers& numbers,
               const meshing::SolutionData* fields, bool point_refs) {
  const MeshData part = visible_part(piece, numbers.share);
  meshing::SolutionData values = meshing::solution_from_metric(piece.log_metrics);
  if (fields) std::ranges::copy(fields->fields, std::back_inserter(values.fields));
  const std::vector<std::int64_t> ids(numbers.points.begin(), numbers.points.end());
  meshing::write_vtu_piece(path, {part, values, {}}, ids, point_refs, {}, cell_data(piece, part));
}

/// The subdomains of all pieces, ascending.
std::vector<SubdomainId> all_subdomains(Peers& peers, std::span<const MeshPiece> mine) {
  std::vector<SubdomainId> here;
  for (const MeshPiece& piece : mine) here.push_back(piece.subdomain);
  std::vector<SubdomainId> all = allgather_joined(peers, here);
  std::ranges::sort(all);
  return all;
}

// --- ParMmg

std::vector<meshing::GmfCommunicator> communicators_of(const MeshPiece& piece, const PieceNumbers& numbers) {
  std::map<SubdomainId, meshing::GmfCommunicator> by_part;
  for (const auto& [vertex, other] : piece.shared) {
    meshing::GmfCommunicator& communicator = by_part[other];
    communicator.part = static_cast<std::int32_t>(other.value);
    communicator.points.push_back(vertex);
    communicator.global.push_back(numbers.points[vertex]);
  }
  std::vector<meshing::GmfCommunicator> communicators;
  for (auto& [other, communicator] : by_part) communicators.push_back(std::move(communicator));
  return communicators;
}

/// NAME.S.meshb
fs::path part_name(const fs::path& mesh, SubdomainId subdomain) {
  return mesh.parent_path() /
         (mesh.stem().string() + "." + std::to_string(subdomain.value) + mesh.extension().string());
}

}  // namespace

void write_pieces_as_vtu(Peers& peers, std::span<const MeshPiece> mine, const fs::path& index,
                         const PieceFields& fields) {
  const Numbering numbering = number_pieces(peers, mine);
  const std::vector<SubdomainId> subdomains = all_subdomains(peers, mine);
  const bool point_refs = have_point_refs(peers, mine);
  std::list<meshing::FormerFile> former;  // what was there comes back when anybody fails
  agree_on(peers, [&] {
    for (std::size_t p = 0; p < mine.size(); ++p) {
      const fs::path path = index.parent_path() / vtu_name(index, mine[p].subdomain);
      former.emplace_back(path);
      write_vtu(path, mine[p], numbering.pieces[p], fields.of_pieces.empty() ? nullptr : &fields.of_pieces[p],
                point_refs);
    }
  });
  agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    std::vector<std::string> names;
    for (const SubdomainId subdomain : subdomains) names.push_back(vtu_name(index, subdomain));
    meshing::write_pvtu_index(index, kinds_of(fields), point_refs, {"subdomain", "quality"}, names);
  });
}

void write_pieces_for_parmmg(Peers& peers, std::span<const MeshPiece> mine, const fs::path& mesh) {
  const Numbering numbering = number_pieces(peers, mine);
  std::list<meshing::FormerFile> former;  // what was there comes back when anybody fails
  agree_on(peers, [&] {
    for (std::size_t p = 0; p < mine.size(); ++p) {
      const fs::path path = part_name(mesh, mine[p].subdomain), metric = meshing::solution_beside(path);
      former.emplace_back(path);
      meshing::write_gmf_part(path, mine[p].mesh, communicators_of(mine[p], numbering.pieces[p]));
      former.emplace_back(metric);
      meshing::write_gmf_solution(metric, meshing::solution_from_metric(mine[p].log_metrics));
    }
  });
}

}  // namespace weft::partition
