// Counts give every row its place, and every rank writes its rows.
#include "partition/output/output.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/gmf/gmf_slice_writer.h"
#include "meshing/io/ugrid.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/output/numbering.h"
#include "partition/output/own_entities.h"

namespace weft::partition {
namespace {

using namespace meshing::gmf;
using meshing::AtomicFile;
using meshing::GmfPlan;
using meshing::GmfSliceWriter;

/// One file that all ranks write: rank 0 creates it and makes it appear.
class CommonFile {
 public:
  explicit CommonFile(std::filesystem::path name) : name_(std::move(name)) {}

  /// All ranks.
  void create(Peers& peers) {
    agree_on(peers, [&] {
      if (peers.rank() == 0) file_ = std::make_unique<AtomicFile>(name_);
    });
    temporary_ = text_of_first(peers, file_ ? file_->temporary().string() : "");
  }
  const std::filesystem::path& name() const { return name_; }
  const std::filesystem::path& temporary() const { return temporary_; }
  /// On rank 0, when all have written.
  void commit() { file_->commit(); }

 private:
  std::filesystem::path name_, temporary_;
  std::unique_ptr<AtomicFile> file_;  ///< on rank 0
};

/// This rank's pieces and where they go.
struct Share {
  bool first;  ///< the rank that writes what is of no piece
  std::span<const MeshPiece> pieces;
  const Numbering& numbering;
};

void write_rows(GmfSliceWriter& out, const OwnEntities& own, const std::vector<std::int32_t>& tet_refs,
                const MeshCounts& first) {
  out.vertices(first.points, own.points, own.point_refs);
  out.elements(kEdges, first.edges, own.edges, own.edge_refs);
  out.elements(kTriangles, first.triangles, own.triangles, own.triangle_refs);
  out.elements(kTetrahedra, first.tets, own.tets, tet_refs);
  out.indices(kCorners, first.corners, own.corners);
  out.indices(kRidges, first.ridges, own.ridges);
  out.indices(kRequiredVertices, first.required_points, own.required_points);
  out.indices(kRequiredEdges, first.required_edges, own.required_edges);
  out.indices(kRequiredTriangles, first.required_triangles, own.required_triangles);
  out.on_model(kVerticesOnNodes, first.on_nodes, own.on_nodes);
  out.on_model(kVerticesOnEdges, first.on_edges, own.on_edges);
  out.on_model(kVerticesOnFaces, first.on_faces, own.on_faces);
}

/// The metrics of the vertices that a piece owns.
meshing::SolutionData own_metrics(const MeshPiece& piece, const PieceNumbers& numbers) {
  meshing::LogMetricField own;
  for (std::size_t v = 0; v < piece.log_metrics.size(); ++v) {
    if (numbers.share.points[v]) own.push_back(piece.log_metrics[v]);
  }
  return meshing::solution_from_metric(own);
}

/// With the carried model, whose length rank 0 knows.
MeshCounts with_model(Peers& peers, MeshCounts totals, const meshing::Association& carried) {
  meshing::MeshData carrier;
  if (peers.rank() == 0) carrier.association = carried;
  const MeshCounts mine = counts_of(carrier);
  const auto of_first = allgather(peers, std::vector<std::uint64_t>{mine.model_rows, mine.model_in_words})[0];
  totals.model_rows = of_first[0];
  totals.model_in_words = of_first[1] != 0;
  return totals;
}

void write_as_gmf(const Share& share, const meshing::Association& carried, const CommonFile& file,
                  const GmfPlan& plan) {
  GmfSliceWriter out(file.temporary(), plan);
  if (share.first) {
    out.frame();
    out.model(carried);
  }
  for (std::size_t p = 0; p < share.pieces.size(); ++p) {
    const PieceNumbers& numbers = share.numbering.pieces[p];
    write_rows(out, own_entities(share.pieces[p], numbers), share.pieces[p].mesh.tet_refs, numbers.first);
  }
  out.finish();
}

void write_as_ugrid(const Share& share, const meshing::UgridSliceWriter::Counts& counts,
                    const CommonFile& file) {
  meshing::UgridSliceWriter out(file.temporary(), file.name(), counts);
  if (share.first) out.frame();
  for (std::size_t p = 0; p < share.pieces.size(); ++p) {
    const PieceNumbers& numbers = share.numbering.pieces[p];
    const OwnEntities own = own_entities(share.pieces[p], numbers);
    out.points(numbers.first.points, own.points);
    out.triangles(numbers.first.triangles, own.triangles, own.triangle_refs);
    out.tets(numbers.first.tets, own.tets, share.pieces[p].mesh.tet_refs);
  }
  out.finish();
}

void write_metrics(const Share& share, const CommonFile& file, const GmfPlan& plan) {
  GmfSliceWriter out(file.temporary(), plan);
  if (share.first) out.frame();
  for (std::size_t p = 0; p < share.pieces.size(); ++p)
    out.solution(share.numbering.pieces[p].first.points,
                 own_metrics(share.pieces[p], share.numbering.pieces[p]));
  out.finish();
}

/// All ranks.
meshing::UgridSliceWriter::Counts ugrid_counts(Peers& peers, std::span<const MeshPiece> mine,
                                               const MeshCounts& totals) {
  const auto has_refs = [](const MeshPiece& piece) {
    return std::ranges::any_of(piece.mesh.tet_refs, [](std::int32_t ref) { return ref != 0; });
  };
  const int any = max(peers, static_cast<int>(std::ranges::any_of(mine, has_refs)));
  return {totals.points, totals.triangles, totals.tets, any != 0};
}

}  // namespace

void write_pieces(Peers& peers, std::span<const MeshPiece> mine, const std::filesystem::path& mesh,
                  const std::filesystem::path& solution, const meshing::Association& carried, int version) {
  const Numbering numbering = number_pieces(peers, mine);
  const bool ugrid = meshing::is_ugrid_for_parts(mesh);
  const MeshCounts counts = with_model(peers, numbering.totals, carried);
  const auto in_ugrid = ugrid_counts(peers, mine, numbering.totals);
  std::optional<GmfPlan> mesh_plan, solution_plan;
  agree_on(peers, [&] {
    if (!ugrid) mesh_plan = GmfPlan::of_mesh(mesh, counts, version);
    if (!solution.empty())
      solution_plan =
          GmfPlan::of_solution(solution, numbering.totals.points, {meshing::Field::Kind::tensor}, version);
  });
  CommonFile mesh_file(mesh), solution_file(solution);
  mesh_file.create(peers);
  if (solution_plan) solution_file.create(peers);
  agree_on(peers, [&] {
    const Share share{peers.rank() == 0, mine, numbering};
    ugrid ? write_as_ugrid(share, in_ugrid, mesh_file) : write_as_gmf(share, carried, mesh_file, *mesh_plan);
    if (solution_plan) write_metrics(share, solution_file, *solution_plan);
  });
  agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    mesh_file.commit();
    if (solution_plan) solution_file.commit();
  });
}

}  // namespace weft::partition
