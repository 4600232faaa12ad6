// Counts give every row its place, and every rank writes its rows.
#include "partition/output/output.h"

#include <algorithm>
#include <array>
#include <exception>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "meshing/io/files/single_precision.h"
#include "meshing/io/gmf/gmf_slice_writer.h"
#include "meshing/io/mesh_file.h"
#include "meshing/metric/metric_field.h"
#include "partition/communication/agreement.h"
#include "partition/output/common_file.h"
#include "partition/output/common_text.h"
#include "partition/output/gmf_output.h"
#include "partition/output/numbering.h"
#include "partition/output/own_entities.h"
#include "partition/output/whole_mesh.h"

namespace weft::partition {
namespace {

using namespace meshing::gmf;
using meshing::GmfPlan;
using meshing::GmfSliceWriter;

/// This rank's pieces and where they go.
struct Share {
  bool first;  ///< the rank that writes what is of no piece
  std::span<const MeshPiece> pieces;
  const Numbering& numbering;
  const PieceFields& fields;
};

/// By so many tets at a time: a piece may be all that a rank has.
void write_tets(GmfSliceWriter& out, const MeshPiece& piece, const PieceNumbers& numbers) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 14;
  const std::vector<std::int32_t>& refs = piece.mesh.tet_refs;
  for (std::size_t begin = 0; begin < refs.size(); begin += kAtOnce) {
    const std::size_t n = std::min(kAtOnce, refs.size() - begin);
    out.elements(kTetrahedra, numbers.first.tets + begin, own_tets(piece, numbers, begin, n),
                 std::span(refs).subspan(begin, n));
  }
}

void write_rows(GmfSliceWriter& out, const MeshPiece& piece, const PieceNumbers& numbers) {
  const OwnEntities own = own_entities(piece, numbers);
  const MeshCounts& first = numbers.first;
  out.vertices(first.points, own.points, own.point_refs);
  out.elements(kEdges, first.edges, own.edges, own.edge_refs);
  out.elements(kTriangles, first.triangles, own.triangles, own.triangle_refs);
  write_tets(out, piece, numbers);
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
  return meshing::solution_from_metric(own_log_metrics(piece, numbers));
}

/// The fields at the vertices that piece `p` owns.
meshing::SolutionData own_fields(const Share& share, std::size_t p) {
  meshing::SolutionData own;
  if (share.fields.kinds.fields.empty()) return own;
  const std::vector<std::uint8_t>& mine = share.numbering.pieces[p].share.points;
  own.num_points = static_cast<std::size_t>(std::ranges::count(mine, 1));
  for (const meshing::Field& field : share.fields.of_pieces[p].fields) {
    const auto n = static_cast<std::size_t>(meshing::components(field.kind));
    meshing::Field& values = own.fields.emplace_back(field.kind, std::vector<double>(), field.name);
    for (std::size_t v = 0; v < mine.size(); ++v)
      if (mine[v])
        values.values.insert(values.values.end(), field.values.begin() + static_cast<std::ptrdiff_t>(v * n),
                             field.values.begin() + static_cast<std::ptrdiff_t>((v + 1) * n));
  }
  return own;
}

/// Metrics and fields at the vertices that piece `p` owns.
meshing::SolutionData own_values(const Share& share, std::size_t p) {
  meshing::SolutionData values = own_metrics(share.pieces[p], share.numbering.pieces[p]);
  std::ranges::move(own_fields(share, p).fields, std::back_inserter(values.fields));
  return values;
}

/// With the carried model, whose length rank 0 knows.
MeshCounts with_model(Peers& peers, MeshCounts totals, const meshing::Association& carried, bool text) {
  meshing::MeshData carrier;
  if (peers.rank() == 0) carrier.association = carried;
  const MeshCounts mine = counts_of(carrier, text);
  const auto of_first = allgather(peers, std::vector<std::uint64_t>{mine.model_rows, mine.model_in_words})[0];
  totals.model_rows = of_first[0];
  totals.model_in_words = of_first[1] != 0;
  return totals;
}

/// What this rank has of a GMF file: what is of no piece comes before all pieces.
std::vector<GmfPart> gmf_parts(const Share& share, const meshing::Association& carried) {
  std::vector<GmfPart> parts;
  if (share.first) parts.push_back({0, [&carried](GmfSliceWriter& out) { out.model(carried); }});
  for (std::size_t p = 0; p < share.pieces.size(); ++p)
    parts.push_back({std::uint64_t{share.pieces[p].subdomain.value} + 1, [&share, p](GmfSliceWriter& out) {
                       write_rows(out, share.pieces[p], share.numbering.pieces[p]);
                     }});
  return parts;
}

/// action(p, its rows) for each piece. `values_inside`: metrics and fields go into the mesh file too.
template <class Action>
void for_parts(const Share& share, const std::vector<FirstWithRef>& firsts, bool values_inside,
               const Action& action) {
  for (std::size_t p = 0; p < share.pieces.size(); ++p) {
    const PieceNumbers& numbers = share.numbering.pieces[p];
    const OwnEntities own = own_entities(share.pieces[p], numbers);
    const auto tets = own_tets(share.pieces[p], numbers);
    const meshing::SolutionData fields = values_inside ? own_values(share, p) : meshing::SolutionData{};
    action(p,
           meshing::MeshPart{numbers.first.points,
                             own.points,
                             own.point_refs,
                             {tets, share.pieces[p].mesh.tet_refs, numbers.first.tets, firsts[p].tets},
                             {own.triangles, own.triangle_refs, numbers.first.triangles, firsts[p].triangles},
                             {own.edges, own.edge_refs, numbers.first.edges, firsts[p].edges},
                             fields});
  }
}

/// A mesh file of any format but GMF, until it can appear.
class CommonMesh {
 public:
  CommonMesh(Peers& peers, const Share& share, const std::filesystem::path& name,
             const meshing::RefNames& names)
      : share_(share), file_(name), mesh_(describe_pieces(peers, share.pieces, share.numbering)) {
    if (meshing::holds_fields(name)) {
      mesh_.whole.fields = meshing::solution_from_metric({});
      std::ranges::copy(share.fields.kinds.fields, std::back_inserter(mesh_.whole.fields.fields));
      mesh_.whole.fields.num_points = share.numbering.totals.points;
    }
    if (share.first) mesh_.whole.names = names;
  }

  /// All ranks.
  void create(Peers& peers) {
    file_.create(peers);
    agree_on(peers, [&] {
      refuse_rounding();
      if (share_.first) places_ = meshing::begin_parts(file_.temporary(), file_.name(), mesh_.whole);
    });
    places_ = allgather(peers, places_)[0];
  }
  void write() {
    const auto out = meshing::open_part(file_.target(), mesh_.whole, places_);
    for_parts(share_, mesh_.pieces, !mesh_.whole.fields.fields.empty(),
              [&](std::size_t, const meshing::MeshPart& part) { out->write(part); });
    out->finish();
  }
  /// All ranks, when all have written.
  void deliver(Peers& peers) { file_.deliver(peers); }
  /// On rank 0, when all has been delivered.
  void commit() { file_.commit(); }

 private:
  void refuse_rounding() const {
    if (!meshing::has_short_reals(file_.name())) return;
    for (std::size_t p = 0; p < share_.pieces.size(); ++p) {
      const PieceNumbers& numbers = share_.numbering.pieces[p];
      const meshing::MeshData& mesh = share_.pieces[p].mesh;
      const auto corners = [&](std::size_t t) {
        const auto& [a, b, c, d] = mesh.tets[t];
        return std::array{mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]};
      };
      meshing::refuse_if_rounding_breaks(own_entities(share_.pieces[p], numbers).points, numbers.first.points,
                                         mesh.tets.size(), numbers.first.tets, corners,
                                         file_.name().string());
    }
  }

  const Share& share_;
  CommonFile file_;
  DescribedMesh mesh_;
  meshing::PartPlaces places_;
};

/// A .solb or .sol of metrics or of fields of these kinds; nothing without a name, and for no fields. `own`:
/// the values of the vertices that a piece owns.
std::optional<GmfOutput> solution_output(const Share& share, const std::filesystem::path& name,
                                         const meshing::SolutionData& kinds,
                                         const std::function<meshing::SolutionData(std::size_t)>& own,
                                         int version) {
  if (name.empty() || kinds.fields.empty()) return std::nullopt;
  std::vector<meshing::Field::Kind> of_fields;
  for (const meshing::Field& field : kinds.fields) of_fields.push_back(field.kind);
  GmfPlan plan = GmfPlan::of_solution(name, share.numbering.totals.points, of_fields, version);
  std::vector<GmfPart> parts;
  for (std::size_t p = 0; p < share.pieces.size(); ++p)
    parts.push_back({share.pieces[p].subdomain.value, [&share, own, p](GmfSliceWriter& out) {
                       out.solution(share.numbering.pieces[p].first.points, own(p));
                     }});
  return GmfOutput(name, std::move(plan), std::move(parts));
}

/// All ranks: the mesh itself as GMF.
GmfOutput mesh_output(Peers& peers, const Share& share, const std::filesystem::path& name,
                      const meshing::Association& carried, int version) {
  const MeshCounts counts = with_model(peers, share.numbering.totals, carried, is_text(name));
  return {name, GmfPlan::of_mesh(name, counts, version), gmf_parts(share, carried)};
}

}  // namespace

bool can_write_pieces(const std::filesystem::path& mesh) {
  return is_mesh(mesh) || meshing::can_be_written_in_parts(mesh) || meshing::can_be_written_as_text(mesh);
}

/// The mesh and the solutions beside it.
struct PiecesOutput::Files {
  Files(const Share& of_rank, const std::filesystem::path& mesh_name) : share(of_rank), name(mesh_name) {}

  void begin_mesh(Peers& peers, const meshing::Association& carried, int version,
                  const meshing::RefNames& names) {
    if (is_mesh(name)) {
      mesh.emplace<GmfOutput>(mesh_output(peers, share, name, carried, version));
    } else if (meshing::can_be_written_as_text(name)) {
      described = describe_pieces(peers, share.pieces, share.numbering);
      if (share.first) described.whole.names = names;
      mesh.emplace<CommonText>(name, described.whole, [this](const auto& action) {
        for_parts(share, described.pieces, false, [&](std::size_t p, const meshing::MeshPart& part) {
          action(share.pieces[p].subdomain.value, part);
        });
      });
    } else {
      mesh.emplace<CommonMesh>(peers, share, name, names);
    }
  }
  void begin_solutions(const std::filesystem::path& solution, int version) {
    metrics = solution_output(
        share, solution, meshing::solution_from_metric({}),
        [this](std::size_t p) { return own_metrics(share.pieces[p], share.numbering.pieces[p]); }, version);
    fields = solution_output(
        share, share.fields.file, share.fields.kinds, [this](std::size_t p) { return own_fields(share, p); },
        version);
  }

  template <class Action>
  void for_each(const Action& action) {
    std::visit(
        [&](auto& file) {
          if constexpr (!std::is_same_v<decltype(file), std::monostate&>) action(file);
        },
        mesh);
    if (metrics) action(*metrics);
    if (fields) action(*fields);
  }

  const Share share;
  const std::filesystem::path name;
  DescribedMesh described;  ///< of a text format
  std::variant<std::monostate, GmfOutput, CommonText, CommonMesh> mesh;
  std::optional<GmfOutput> metrics, fields;
  std::exception_ptr failure;  ///< of write()
};

PiecesOutput::PiecesOutput(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering,
                           const std::filesystem::path& mesh, const std::filesystem::path& solution,
                           const meshing::Association& carried, int version, const meshing::RefNames& names,
                           const PieceFields& fields)
    : files_(std::make_unique<Files>(Share{peers.rank() == 0, mine, numbering, fields}, mesh)) {
  files_->begin_mesh(peers, carried, version, names);
  files_->begin_solutions(solution, version);
  files_->for_each([&](auto& file) { file.create(peers); });
}

PiecesOutput::~PiecesOutput() = default;

void PiecesOutput::write() noexcept {
  try {
    files_->for_each([](auto& file) { file.write(); });
  } catch (...) {
    files_->failure = std::current_exception();
  }
}

void PiecesOutput::finish(Peers& peers) {
  agree_on(peers, [&] {
    if (files_->failure) std::rethrow_exception(files_->failure);
  });
  files_->for_each([&](auto& file) { file.deliver(peers); });
  agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    const meshing::FormerFile mesh_before(files_->name), fields_before(files_->share.fields.file);
    std::visit(
        [](auto& file) {
          if constexpr (!std::is_same_v<decltype(file), std::monostate&>) file.commit();
        },
        files_->mesh);
    if (files_->fields) files_->fields->commit();
    if (files_->metrics) files_->metrics->commit();
  });
}

void write_pieces(Peers& peers, std::span<const MeshPiece> mine, const std::filesystem::path& mesh,
                  const std::filesystem::path& solution, const meshing::Association& carried, int version,
                  const meshing::RefNames& names, const PieceFields& fields) {
  const Numbering numbering = number_pieces(peers, mine);
  PiecesOutput output(peers, mine, numbering, mesh, solution, carried, version, names, fields);
  output.write();
  output.finish(peers);
}

}  // namespace weft::partition
