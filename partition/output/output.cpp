// Counts give every row its place, and every rank writes its rows.
#include "partition/output/output.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/gmf/gmf_slice_writer.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/agreement.h"
#include "partition/output/numbering.h"
#include "partition/output/own_entities.h"
#include "partition/output/whole_mesh.h"

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

/// `metrics_inside`: the metrics go into the mesh file too.
void write_parts(const Share& share, const std::vector<FirstWithRef>& firsts, bool metrics_inside,
                 meshing::PartWriter& out) {
  for (std::size_t p = 0; p < share.pieces.size(); ++p) {
    const PieceNumbers& numbers = share.numbering.pieces[p];
    const OwnEntities own = own_entities(share.pieces[p], numbers);
    const meshing::SolutionData fields =
        metrics_inside ? meshing::solution_from_metric(own.log_metrics) : meshing::SolutionData{};
    out.write({numbers.first.points,
               own.points,
               own.point_refs,
               {own.tets, share.pieces[p].mesh.tet_refs, numbers.first.tets, firsts[p].tets},
               {own.triangles, own.triangle_refs, numbers.first.triangles, firsts[p].triangles},
               {own.edges, own.edge_refs, numbers.first.edges, firsts[p].edges},
               fields});
  }
  out.finish();
}

/// A mesh file of any format but GMF, until it can appear.
class CommonMesh {
 public:
  CommonMesh(Peers& peers, const Share& share, const std::filesystem::path& name,
             const meshing::RefNames& names)
      : share_(share), file_(name), mesh_(describe_pieces(peers, share.pieces, share.numbering)) {
    const bool metrics_inside = meshing::holds_fields(name);
    if (metrics_inside) mesh_.whole.fields.fields = meshing::solution_from_metric({}).fields;
    if (share.first) mesh_.whole.names = names;
  }

  /// All ranks.
  void create(Peers& peers) {
    file_.create(peers);
    agree_on(peers, [&] {
      if (share_.first) places_ = meshing::begin_parts(file_.temporary(), file_.name(), mesh_.whole);
    });
    places_ = allgather(peers, places_)[0];
  }
  void write() {
    const auto out = meshing::open_part(file_.temporary(), file_.name(), mesh_.whole, places_);
    write_parts(share_, mesh_.pieces, !mesh_.whole.fields.fields.empty(), *out);
  }
  /// On rank 0, when all have written.
  void commit() { file_.commit(); }

 private:
  const Share& share_;
  CommonFile file_;
  DescribedMesh mesh_;
  meshing::PartPlaces places_;
};

void write_metrics(const Share& share, const CommonFile& file, const GmfPlan& plan) {
  GmfSliceWriter out(file.temporary(), plan);
  if (share.first) out.frame();
  for (std::size_t p = 0; p < share.pieces.size(); ++p)
    out.solution(share.numbering.pieces[p].first.points,
                 own_metrics(share.pieces[p], share.numbering.pieces[p]));
  out.finish();
}

/// A .meshb likewise.
class CommonGmf {
 public:
  /// All ranks.
  CommonGmf(Peers& peers, const Share& share, const std::filesystem::path& name,
            const meshing::Association& carried, int version)
      : share_(share), carried_(carried), file_(name) {
    const MeshCounts counts = with_model(peers, share.numbering.totals, carried);
    agree_on(peers, [&] { plan_ = GmfPlan::of_mesh(name, counts, version); });
  }
  void create(Peers& peers) { file_.create(peers); }
  void write() { write_as_gmf(share_, carried_, file_, *plan_); }
  void commit() { file_.commit(); }

 private:
  const Share& share_;
  const meshing::Association& carried_;
  CommonFile file_;
  std::optional<GmfPlan> plan_;
};

/// Mesh and, where it has a name, solution.
template <class Mesh>
void write_both(Peers& peers, const Share& share, Mesh& mesh, const std::filesystem::path& solution,
                int version) {
  std::optional<GmfPlan> plan;
  agree_on(peers, [&] {
    if (!solution.empty())
      plan = GmfPlan::of_solution(solution, share.numbering.totals.points, {meshing::Field::Kind::tensor},
                                  version);
  });
  CommonFile solution_file(solution);
  mesh.create(peers);
  if (plan) solution_file.create(peers);
  agree_on(peers, [&] {
    mesh.write();
    if (plan) write_metrics(share, solution_file, *plan);
  });
  agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    mesh.commit();
    if (plan) solution_file.commit();
  });
}

bool is_gmf(const std::filesystem::path& mesh) {
  return mesh.extension() == ".meshb" || mesh.extension() == ".mesh";
}

}  // namespace

bool can_write_pieces(const std::filesystem::path& mesh) {
  return mesh.extension() == ".meshb" || meshing::can_be_written_in_parts(mesh);
}

void write_pieces(Peers& peers, std::span<const MeshPiece> mine, const std::filesystem::path& mesh,
                  const std::filesystem::path& solution, const meshing::Association& carried, int version,
                  const meshing::RefNames& names) {
  const Numbering numbering = number_pieces(peers, mine);
  const Share share{peers.rank() == 0, mine, numbering};
  if (is_gmf(mesh)) {
    CommonGmf file(peers, share, mesh, carried, version);
    write_both(peers, share, file, solution, version);
  } else {
    CommonMesh file(peers, share, mesh, names);
    write_both(peers, share, file, solution, version);
  }
}

}  // namespace weft::partition
