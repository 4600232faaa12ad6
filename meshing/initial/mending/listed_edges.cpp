#include "meshing/initial/mending/listed_edges.h"

#include <algorithm>
#include <utility>

#include "meshing/initial/clean_triangles.h"

namespace weft::meshing {
namespace {

/// What an index of a list means, for each of `count` entities.
std::vector<bool> flags_of(const std::vector<std::uint32_t>& list, std::size_t count) {
  std::vector<bool> flags(count);
  for (const std::uint32_t i : list)
    if (i < count) flags[i] = true;
  return flags;
}

std::vector<std::uint32_t> list_of(const std::vector<bool>& flags) {
  std::vector<std::uint32_t> list;
  for (std::uint32_t i = 0; i < flags.size(); ++i)
    if (flags[i]) list.push_back(i);
  return list;
}

}  // namespace

ListedEdges::ListedEdges(const MeshData& surface) {
  pieces_.reserve(surface.edges.size());
  for (std::uint32_t e = 0; e < surface.edges.size(); ++e) pieces_.push_back({surface.edges[e], e});
}

void ListedEdges::renumber(std::span<const std::uint32_t> now) {
  for (Piece& piece : pieces_)
    for (std::uint32_t& v : piece.ends)
      if (v < now.size() && now[v] != TriangleCleaning::kUnused) v = now[v];
}

bool ListedEdges::cut(const EdgeCuts& cuts) {
  if (cuts.empty()) return false;
  std::vector<Piece> pieces;
  pieces.reserve(pieces_.size());
  for (const Piece& piece : pieces_) {
    const auto& [a, b] = piece.ends;
    const auto at = cuts.find(edge_key(a, b));
    if (at == cuts.end()) {
      pieces.push_back(piece);
      continue;
    }
    std::vector<std::uint32_t> vertices = at->second;
    if (a > b) std::ranges::reverse(vertices);
    vertices.push_back(b);
    std::uint32_t last = a;
    for (const std::uint32_t v : vertices) pieces.push_back({{std::exchange(last, v), v}, piece.edge});
  }
  const bool any = pieces.size() > pieces_.size();
  pieces_ = std::move(pieces);
  return any;
}

void ListedEdges::give_to(MeshData& surface) const {
  const std::vector<bool> was_ridge = flags_of(surface.ridges, surface.edges.size()),
                          was_required = flags_of(surface.required_edges, surface.edges.size());
  const std::vector<std::int32_t> refs = std::exchange(surface.edge_refs, {});
  std::vector<bool> ridge, required;
  std::unordered_map<std::uint64_t, std::size_t> there;
  surface.edges.clear();
  for (const Piece& piece : pieces_) {
    const auto& [a, b] = piece.ends;
    if (a == b) continue;
    const auto [at, is_new] = there.try_emplace(edge_key(a, b), surface.edges.size());
    if (is_new) {
      surface.edges.push_back(piece.ends);
      surface.edge_refs.push_back(refs[piece.edge]);
      ridge.push_back(false), required.push_back(false);
    }
    ridge[at->second] = ridge[at->second] || was_ridge[piece.edge];
    required[at->second] = required[at->second] || was_required[piece.edge];
  }
  surface.ridges = list_of(ridge);
  surface.required_edges = list_of(required);
}

}  // namespace weft::meshing
