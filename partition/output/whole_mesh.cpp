// Counts, boxes and corners of every piece go to everyone, and are put together in the order of the pieces.
#include "partition/output/whole_mesh.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using meshing::Point;
using meshing::RefCounts;
using meshing::WholeMesh;

constexpr RefCounts FirstWithRef::*kRefCounts[] = {&FirstWithRef::tets, &FirstWithRef::triangles,
                                                   &FirstWithRef::edges};
constexpr RefCounts WholeMesh::*kTotals[] = {&WholeMesh::tets, &WholeMesh::triangles, &WholeMesh::edges};

struct RefRow {
  std::uint64_t subdomain, count;
  std::int32_t kind, ref;
};
struct BoxRow {
  std::uint64_t subdomain;
  Point low, high;
};

RefCounts count_own(const std::vector<std::int32_t>& refs, const std::vector<std::uint8_t>& own) {
  RefCounts counts;
  for (std::size_t i = 0; i < refs.size(); ++i)
    if (own[i]) ++counts[refs[i]];
  return counts;
}

void add_counts(const MeshPiece& piece, const PieceShare& share, std::vector<RefRow>& rows) {
  const RefCounts counts[] = {meshing::count_refs(piece.mesh.tet_refs),
                              count_own(piece.mesh.triangle_refs, share.triangles),
                              count_own(piece.mesh.edge_refs, share.edges)};
  for (std::int32_t kind = 0; kind < 3; ++kind)
    for (const auto& [ref, count] : counts[kind]) rows.push_back({piece.subdomain.value, count, kind, ref});
}

/// The rows of all ranks in the order of the subdomains.
template <class Row>
std::vector<Row> gathered(Peers& peers, const std::vector<Row>& here) {
  std::vector<Row> all = allgather_joined(peers, here);
  std::ranges::stable_sort(all, {}, &Row::subdomain);
  return all;
}

void sum_refs(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering,
              DescribedMesh& result) {
  std::vector<RefRow> rows;
  std::unordered_map<std::uint64_t, std::size_t> piece_of;
  for (std::size_t p = 0; p < mine.size(); ++p) {
    add_counts(mine[p], numbering.pieces[p].share, rows);
    piece_of[mine[p].subdomain.value] = p;
  }
  for (const RefRow& row : gathered(peers, rows)) {
    std::uint64_t& total = (result.whole.*kTotals[row.kind])[row.ref];
    const auto here = piece_of.find(row.subdomain);
    if (here != piece_of.end()) (result.pieces[here->second].*kRefCounts[row.kind])[row.ref] = total;
    total += row.count;
  }
}

void include(const BoxRow& row, bool first, WholeMesh& whole) {
  if (first) {
    whole.low = row.low;
    whole.high = row.high;
  }
  for (int c = 0; c < 3; ++c) {
    whole.low[c] = std::min(whole.low[c], row.low[c]);
    whole.high[c] = std::max(whole.high[c], row.high[c]);
  }
}

/// The box of the points that a piece owns, if any.
void add_box(const MeshPiece& piece, const std::vector<std::uint8_t>& own, std::vector<BoxRow>& rows) {
  WholeMesh box;
  bool first = true;
  for (std::size_t v = 0; v < own.size(); ++v) {
    if (!own[v]) continue;
    include({0, piece.mesh.points[v], piece.mesh.points[v]}, first, box);
    first = false;
  }
  if (!first) rows.push_back({piece.subdomain.value, box.low, box.high});
}

void find_box(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering, WholeMesh& whole) {
  std::vector<BoxRow> rows;
  for (std::size_t p = 0; p < mine.size(); ++p) add_box(mine[p], numbering.pieces[p].share.points, rows);
  bool first = true;
  for (const BoxRow& row : gathered(peers, rows)) {
    include(row, first, whole);
    first = false;
  }
}

struct CornerRow {
  std::uint64_t subdomain;
  WholeMesh::Corner corner;
};

void collect_corners(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering,
                     WholeMesh& whole) {
  std::vector<CornerRow> rows;
  for (std::size_t p = 0; p < mine.size(); ++p) {
    const meshing::MeshData& mesh = mine[p].mesh;
    for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
      const std::uint32_t v = mesh.corners[i];
      if (numbering.pieces[p].share.corners[i])
        rows.push_back(
            {mine[p].subdomain.value, {numbering.pieces[p].points[v], mesh.points[v], mesh.point_refs[v]}});
    }
  }
  for (const CornerRow& row : gathered(peers, rows)) whole.corners.push_back(row.corner);
}

}  // namespace

bool have_point_refs(Peers& peers, std::span<const MeshPiece> mine) {
  const auto has_refs = [](const MeshPiece& piece) { return meshing::has_refs(piece.mesh.point_refs); };
  return max(peers, static_cast<int>(std::ranges::any_of(mine, has_refs))) != 0;
}

DescribedMesh describe_pieces(Peers& peers, std::span<const MeshPiece> mine, const Numbering& numbering) {
  DescribedMesh result;
  result.pieces.resize(mine.size());
  result.whole.points = result.whole.fields.num_points = numbering.totals.points;
  sum_refs(peers, mine, numbering, result);
  find_box(peers, mine, numbering, result.whole);
  collect_corners(peers, mine, numbering, result.whole);
  result.whole.point_refs = have_point_refs(peers, mine);
  return result;
}

}  // namespace weft::partition
