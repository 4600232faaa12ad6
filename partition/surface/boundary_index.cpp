// Records meet at the home of their lowest vertex, where whoever has that vertex asks.
#include "partition/surface/boundary_index.h"

#include <algorithm>
#include <span>
#include <utility>

#include "meshing/base/release.h"
#include "meshing/geometry/surface/surface_piece.h"
#include "partition/communication/at_home.h"

namespace weft::partition {

using meshing::CurveId;
using meshing::PatchId;

namespace {

std::uint32_t home_vertex(const BoundaryRecords::Vertex& v) { return v.number; }
std::uint32_t home_vertex(const BoundaryRecords::Face& f) { return f.vertices[0]; }
std::uint32_t home_vertex(const BoundaryRecords::Edge& e) { return e.vertices[0]; }

constexpr auto kHomeVertex = [](const auto& record) { return home_vertex(record); };

template <class T>
void sort_by_home_vertex(std::vector<T>& records) {
  std::ranges::sort(records, {}, kHomeVertex);
}

/// All ranks: the records whose home this is, in the order of their vertices.
template <class T>
std::vector<T> sent_home(Peers& peers, std::vector<T> mine) {
  const auto ranks = static_cast<std::uint32_t>(peers.ranks());
  if (ranks > 1) {
    std::vector<std::vector<T>> to_each(ranks);
    for (const T& record : mine) to_each[home_vertex(record) % ranks].push_back(record);
    meshing::release(mine);
    mine = all_to_all_joined(peers, std::move(to_each));
  }
  sort_by_home_vertex(mine);
  return mine;
}

void merge(std::vector<BoundaryRecords::Vertex>& vertices) {
  sort_by_home_vertex(vertices);
  std::size_t end = 0;
  for (const BoundaryRecords::Vertex& v : vertices) {
    if (end == 0 || vertices[end - 1].number != v.number) {
      vertices[end++] = v;
      continue;
    }
    BoundaryRecords::Vertex& known = vertices[end - 1];
    known.kind = std::max(known.kind, v.kind);
    known.flags = static_cast<std::uint8_t>(known.flags | v.flags);
    known.hint = std::min(known.hint, v.hint);
  }
  vertices.resize(end);
}

/// Sorts by all vertices, and drops what has one that is not among the ascending `vertices`.
template <class T>
void keep_between(std::span<const std::uint32_t> vertices, std::vector<T>& records) {
  std::erase_if(records, [&](const T& record) {
    return !std::ranges::all_of(record.vertices,
                                [&](std::uint32_t v) { return std::ranges::binary_search(vertices, v); });
  });
  std::ranges::sort(records, {}, &T::vertices);
}

}  // namespace

BoundaryIndex::BoundaryIndex(Peers& peers, BoundaryRecords mine, const std::vector<std::uint32_t>& vertices) {
  const auto asked = asked_at_home(peers, vertices);
  const auto told = [&](auto here) { return told_at_home(peers, asked, std::move(here), kHomeVertex); };
  merge(mine.vertices);
  std::vector<BoundaryRecords::Vertex> here = sent_home(peers, std::exchange(mine.vertices, {}));
  merge(here);
  records_.vertices = told(std::move(here));
  sort_by_home_vertex(records_.vertices);
  records_.faces = told(sent_home(peers, std::exchange(mine.faces, {})));
  keep_between(vertices, records_.faces);
  records_.edges = told(sent_home(peers, std::exchange(mine.edges, {})));
  keep_between(vertices, records_.edges);
}

std::uint32_t BoundaryIndex::vertex(std::uint32_t number) const {
  const auto& all = records_.vertices;
  const auto found = std::ranges::lower_bound(all, number, {}, &BoundaryRecords::Vertex::number);
  return found != all.end() && found->number == number ? static_cast<std::uint32_t>(found - all.begin())
                                                       : kNone;
}

PatchId BoundaryIndex::patch(std::array<std::uint32_t, 3> face) const {
  std::ranges::sort(face);
  const auto found = std::ranges::lower_bound(records_.faces, face, {}, &BoundaryRecords::Face::vertices);
  return found != records_.faces.end() && found->vertices == face ? found->patch : PatchId{};
}

CurveId BoundaryIndex::curve(std::uint32_t a, std::uint32_t b) const {
  const std::array<std::uint32_t, 2> edge{std::min(a, b), std::max(a, b)};
  const auto found = std::ranges::lower_bound(records_.edges, edge, {}, &BoundaryRecords::Edge::vertices);
  return found != records_.edges.end() && found->vertices == edge ? found->curve : CurveId{};
}

}  // namespace weft::partition
