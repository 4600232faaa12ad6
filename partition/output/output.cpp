// Counts make the plan, the plan gives every row its place, every rank writes its rows.
#include "partition/output/output.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/gmf/gmf_slice_writer.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/agreement.h"
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
  explicit CommonFile(GmfPlan plan) : plan_(std::move(plan)) {}

  /// All ranks.
  void create(Peers& peers) {
    agree_on(peers, [&] {
      if (peers.rank() == 0) file_ = std::make_unique<AtomicFile>(plan_.name());
    });
    temporary_ = text_of_first(peers, file_ ? file_->temporary().string() : "");
  }
  /// write(writer) writes this rank's rows; `first` is for one of the ranks.
  template <class Write>
  void write_part(bool first, const Write& write) {
    GmfSliceWriter writer(temporary_, plan_);
    if (first) writer.frame();
    write(writer);
    writer.finish();
  }
  /// On rank 0, when all have written.
  void commit() { file_->commit(); }

 private:
  GmfPlan plan_;
  std::filesystem::path temporary_;
  std::unique_ptr<AtomicFile> file_;  ///< on rank 0
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

void write_parts(bool first, std::span<const MeshPiece> mine, const Numbering& numbering,
                 const meshing::Association& carried, CommonFile& mesh, CommonFile* solution) {
  mesh.write_part(first, [&](GmfSliceWriter& out) {
    if (first) out.model(carried);
    for (std::size_t p = 0; p < mine.size(); ++p) {
      const PieceNumbers& numbers = numbering.pieces[p];
      write_rows(out, own_entities(mine[p], numbers), mine[p].mesh.tet_refs, numbers.first);
    }
  });
  if (!solution) return;
  solution->write_part(first, [&](GmfSliceWriter& out) {
    for (std::size_t p = 0; p < mine.size(); ++p)
      out.solution(numbering.pieces[p].first.points, own_metrics(mine[p], numbering.pieces[p]));
  });
}

}  // namespace

void write_pieces(Peers& peers, std::span<const MeshPiece> mine, const std::filesystem::path& mesh,
                  const std::filesystem::path& solution, const meshing::Association& carried, int version) {
  const Numbering numbering = number_pieces(peers, mine);
  const MeshCounts counts = with_model(peers, numbering.totals, carried);
  std::optional<CommonFile> mesh_file, solution_file;
  agree_on(peers, [&] {
    mesh_file.emplace(GmfPlan::of_mesh(mesh, counts, version));
    if (solution.empty()) return;
    solution_file.emplace(
        GmfPlan::of_solution(solution, numbering.totals.points, {meshing::Field::Kind::tensor}, version));
  });
  mesh_file->create(peers);
  if (solution_file) solution_file->create(peers);
  agree_on(peers, [&] {
    write_parts(peers.rank() == 0, mine, numbering, carried, *mesh_file,
                solution_file ? &*solution_file : nullptr);
  });
  agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    mesh_file->commit();
    if (solution_file) solution_file->commit();
  });
}

}  // namespace weft::partition
