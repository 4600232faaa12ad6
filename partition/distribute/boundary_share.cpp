// The boundary's work of meshing::import_mesh, with faces matched across ranks.
#include "partition/distribute/boundary_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/boundary_entities.h"
#include "meshing/mesh/touching_edges.h"
#include "partition/communication/input_issue.h"
#include "partition/communication/reduce.h"
#include "partition/distribute/face_records.h"

namespace weft::partition {
namespace {

using meshing::MeshData;
using Tet = std::array<std::uint32_t, 4>;
using Triangle = std::array<std::uint32_t, 3>;

/// All ranks: which of these vertices tets of other ranks have too. Whoever has the point knows who asks.
std::vector<std::uint8_t> used_elsewhere(Peers& peers, const Ranges& points,
                                         const std::vector<std::uint32_t>& numbers) {
  std::vector<std::vector<std::uint32_t>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const std::uint32_t number : numbers) to_each[points.rank_of(number)].push_back(number);
  const auto asked = partition::all_to_all(peers, std::move(to_each));
  const std::uint64_t first = points.first(peers.rank());
  std::vector<std::uint8_t> users(points.first(peers.rank() + 1) - first, 0);
  for (const auto& of_rank : asked)
    for (const std::uint32_t number : of_rank)
      if (std::uint8_t& known = users[number - first]; known < 2) ++known;
  std::vector<std::vector<std::uint8_t>> answers(asked.size());
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const std::uint32_t number : asked[r]) answers[r].push_back(users[number - first] > 1);
  return all_to_all_joined(peers, std::move(answers));
}

/// The faces of the slice, of which those that have both their tets here are mostly nobody else's business.
class SliceFaces {
 public:
  /// All ranks call together.
  SliceFaces(Peers& peers, const MeshSlice& slice, const PlacedTets& placed, const Ranges& points)
      : slice_(slice), tets_(placed.tets), marks_(used_elsewhere(peers, points, placed.numbers)) {
    for (const Triangle& triangle : slice.boundary.triangles)
      for (const std::uint32_t v : triangle) {
        const auto at = std::ranges::lower_bound(placed.numbers, v);
        if (at != placed.numbers.end() && *at == v) marks_[at - placed.numbers.begin()] |= kOnTriangle;
      }
    try {
      neighbours_ = meshing::build_adjacency(tets_, placed.numbers.size()).neighbours;
    } catch (const meshing::InputError&) {
      neighbours_.clear();  // a face has three tets: all faces are to meet, and all ranks will know
    }
  }

  /// False where two tets of one reference lie here on both sides, and no third tet nor triangle can be
  /// there.
  bool is_to_meet(std::uint32_t t, std::size_t f) const {
    if (neighbours_.empty()) return true;
    const std::uint32_t code = neighbours_[t][f];
    if (code == meshing::kNoNeighbour || slice_.tet_refs[t] != slice_.tet_refs[code >> 2]) return true;
    const Triangle mine = corners(t, f), other = corners(code >> 2, code & 3);
    if (marks_[mine[0]] & marks_[mine[1]] & marks_[mine[2]]) return true;
    const auto at = static_cast<std::size_t>(std::ranges::find(other, mine[0]) - other.begin());
    return other[(at + 1) % 3] == mine[1];
  }

 private:
  static constexpr std::uint8_t kOnTriangle = 2;  ///< beside 1: tets of other ranks have the vertex too

  Triangle corners(std::uint32_t t, std::size_t f) const {
    const auto& c = meshing::kTetFaces[f];
    return {tets_[t][c[0]], tets_[t][c[1]], tets_[t][c[2]]};
  }

  const MeshSlice& slice_;
  std::span<const Tet> tets_;
  std::vector<std::uint8_t> marks_;  ///< of vertices
  std::vector<Tet> neighbours_;      ///< empty: not known
};

/// The faces that meet here, sorted.
std::vector<FaceRecord> meet_faces(Peers& peers, const MeshSlice& slice, const PlacedTets& placed,
                                   const Ranges& points) {
  const auto ranks = static_cast<std::uint32_t>(peers.ranks());
  std::vector<std::vector<FaceRecord>> to_each(ranks);
  const SliceFaces faces_here(peers, slice, placed, points);
  for (std::uint32_t t = 0; t < slice.tets.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      if (!faces_here.is_to_meet(t, f)) continue;
      const FaceRecord record = face_record(slice.tets[t], slice.tet_refs[t], slice.first_tet + t, f);
      to_each[record.vertices[0] % ranks].push_back(record);
    }
  std::vector<FaceRecord> faces = all_to_all_joined(peers, std::move(to_each));
  std::sort(faces.begin(), faces.end());
  return faces;
}

/// A face of more than two tets.
void refuse_overused(Peers& peers, const std::vector<FaceRecord>& faces) {
  std::optional<InputIssue> first;
  for (std::size_t i = 0; i + 2 < faces.size() && !first; ++i) {
    if (!same_face(faces[i], faces[i + 2])) continue;
    const auto [a, b, c] = faces[i].vertices;
    first = InputIssue{
        {a, b, c},
        fmt::format("tets {}, {} and {}", faces[i].tet() + 1, faces[i + 1].tet() + 1, faces[i + 2].tet() + 1),
        fmt::format("share the face ({} {} {})", a + 1, b + 1, c + 1)};
  }
  throw_first(peers, first);
}

/// Two positive tets across a face see it turning in opposite ways; the same way means they overlap.
void refuse_overlaps(Peers& peers, const MeshSlice& slice, const Ranges& tets,
                     const std::vector<FaceRecord>& faces) {
  struct Overlap {
    std::uint64_t code = std::numeric_limits<std::uint64_t>::max(), other = 0;
  };
  Overlap least;
  for (std::size_t i = 0; i + 1 < faces.size(); ++i)
    if (same_face(faces[i], faces[i + 1]) && faces[i].odd() == faces[i + 1].odd() &&
        faces[i].code < least.code)
      least = {faces[i].code, faces[i + 1].tet()};
  least = reduce(peers, std::vector{least},
                 [](const Overlap& a, const Overlap& b) { return b.code < a.code ? b : a; })[0];
  if (least.code == Overlap{}.code) return;
  const std::vector<std::uint64_t> numbers{least.code >> 5, least.other};
  const auto both = fetch<Tet>(peers, tets, numbers, [&](std::size_t t) { return slice.tets[t]; });
  throw_first(peers, InputIssue{{},
                                fmt::format("tets {} and {}", numbers[0] + 1, numbers[1] + 1),
                                meshing::overlap_reason(both[0] == both[1])});
}

/// A triangle that the input lacks.
struct Created {
  std::uint64_t code;  ///< of the face
  Triangle vertices;
};

/// What this rank finds out about the triangles whose lowest vertex is its.
struct TriangleFindings {
  std::vector<std::uint32_t> kept, repeated;  ///< indices of triangles
  std::vector<Triangle> outer;                ///< of one tet
  std::vector<Created> created;
};

struct SortedTriangle {
  Triangle vertices;
  std::uint32_t index;
  friend auto operator<=>(const SortedTriangle&, const SortedTriangle&) = default;
};

std::vector<SortedTriangle> my_triangles(const Peers& peers, const std::vector<Triangle>& triangles) {
  std::vector<SortedTriangle> mine;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    SortedTriangle triangle{triangles[i], i};
    std::sort(triangle.vertices.begin(), triangle.vertices.end());
    if (triangle.vertices[0] % static_cast<std::uint32_t>(peers.ranks()) ==
        static_cast<std::uint32_t>(peers.rank()))
      mine.push_back(triangle);
  }
  std::sort(mine.begin(), mine.end());
  return mine;
}

InputIssue no_face(const Triangle& v, std::uint32_t index) {
  return {{index, 0, 0}, meshing::triangle_name(index, v), meshing::kIsNoFace};
}

/// Walks through faces and triangles, both sorted by vertices.
TriangleFindings match_triangles(Peers& peers, const std::vector<FaceRecord>& faces,
                                 const std::vector<Triangle>& triangles) {
  TriangleFindings findings;
  std::optional<InputIssue> first;
  const std::vector<SortedTriangle> mine = my_triangles(peers, triangles);
  auto triangle = mine.begin();
  const auto pass_strangers = [&](const Triangle* face) {
    for (; triangle != mine.end() && (!face || triangle->vertices < *face); ++triangle)
      keep_least(first, no_face(triangles[triangle->index], triangle->index));
  };
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const FaceRecord& face = faces[i];
    const bool paired = i + 1 < faces.size() && same_face(face, faces[i + 1]);
    const bool needed = !paired || face.tet_ref != faces[i + 1].tet_ref;
    if (paired)
      ++i;
    else
      findings.outer.push_back(face.vertices);
    pass_strangers(&face.vertices);
    bool covered = false;
    for (; triangle != mine.end() && triangle->vertices == face.vertices; ++triangle) {
      (covered ? findings.repeated : findings.kept).push_back(triangle->index);
      covered = true;
    }
    if (covered || !needed) continue;
    const Triangle v = face.in_order();
    findings.created.push_back({face.code, {v[0], v[2], v[1]}});
  }
  pass_strangers(nullptr);
  throw_first(peers, first);
  return findings;
}

using Edge = std::array<std::uint32_t, 2>;

Edge edge_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// All ranks: the missing triangles, in the order of their tets over all ranks.
std::vector<Created> in_order_of_tets(Peers& peers, const Ranges& tets, const std::vector<Created>& created) {
  std::vector<std::vector<Created>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const Created& c : created) to_each[tets.rank_of(c.code >> 5)].push_back(c);
  std::vector<Created> mine = all_to_all_joined(peers, std::move(to_each));
  std::ranges::sort(mine, {}, &Created::code);
  return mine;
}

/// The triangles without the repeated ones, and then those that were missing.
void take_triangles(Peers& peers, const MeshData& m, const TriangleFindings& findings, const Ranges& tets,
                    BoundaryShare& b) {
  std::vector<std::uint32_t> repeated = allgather_joined(peers, findings.repeated);
  std::ranges::sort(repeated);
  std::vector<bool> required(m.triangles.size());
  for (const std::uint32_t t : m.required_triangles) required[t] = true;
  for (const std::uint32_t t : findings.kept) {
    const auto before = std::ranges::lower_bound(repeated, t) - repeated.begin();
    b.triangles.push_back(
        {t - static_cast<std::uint32_t>(before), m.triangles[t], m.triangle_refs[t], required[t]});
  }
  if (!repeated.empty()) b.warnings.push_back(meshing::repeated_triangles_warning(repeated.size()));
  const std::vector<Created> created = in_order_of_tets(peers, tets, findings.created);
  const Ranges numbers(peers, created.size());
  const std::uint64_t first = m.triangles.size() - repeated.size() + numbers.first(peers.rank());
  for (std::size_t i = 0; i < created.size(); ++i)
    b.triangles.push_back({static_cast<std::uint32_t>(first + i), created[i].vertices, 0, 0});
  if (numbers.total() > 0) b.warnings.push_back(meshing::created_triangles_warning(numbers.total()));
}

/// All ranks: the sides of triangles that each rank has some of, where their lower vertices say; sorted.
template <class Triangles, class Vertices>
std::vector<Edge> sides_at_home(Peers& peers, const Triangles& triangles, const Vertices& vertices) {
  std::vector<std::vector<Edge>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const auto& triangle : triangles) {
    const Triangle& v = vertices(triangle);
    for (std::size_t i = 0; i < 3; ++i) {
      const Edge side = edge_of(v[i], v[(i + 1) % 3]);
      to_each[side[0] % to_each.size()].push_back(side);
    }
  }
  std::vector<Edge> sides = all_to_all_joined(peers, std::move(to_each));
  std::ranges::sort(sides);
  return sides;
}

/// A listed edge, and when the lists name it last: edges in their order, then required ones in theirs.
struct ListedEdge {
  Edge vertices;
  std::uint64_t named;
  std::uint32_t index;
};

/// Those of this rank's edges that are sides, by vertices and then as they are named. Counts the others.
std::vector<ListedEdge> listed_edges(const Peers& peers, const MeshData& m, const std::vector<Edge>& sides,
                                     std::uint64_t& dropped) {
  const auto ranks = static_cast<std::uint32_t>(peers.ranks()), me = static_cast<std::uint32_t>(peers.rank());
  std::vector<ListedEdge> listed;
  const auto add = [&](std::uint32_t index, std::uint64_t named) {
    const Edge edge = edge_of(m.edges[index][0], m.edges[index][1]);
    if (edge[0] % ranks != me) return;
    if (std::ranges::binary_search(sides, edge))
      listed.push_back({edge, named, index});
    else
      dropped += named < m.edges.size();
  };
  for (std::uint32_t e = 0; e < m.edges.size(); ++e) add(e, e);
  for (std::size_t i = 0; i < m.required_edges.size(); ++i) add(m.required_edges[i], m.edges.size() + i);
  std::ranges::sort(listed, {}, [](const ListedEdge& e) { return std::pair{e.vertices, e.named}; });
  return listed;
}

/// Each once. What is named last counts; of edges at which the mesh touches itself, what is listed first.
void take_edges(const MeshData& m, std::span<const ListedEdge> listed, std::span<const Edge> touching,
                BoundaryShare& b) {
  for (std::size_t begin = 0, end = 0; begin < listed.size(); begin = end) {
    while (end < listed.size() && listed[end].vertices == listed[begin].vertices) ++end;
    const bool touches = std::ranges::binary_search(touching, listed[begin].vertices);
    const ListedEdge& last = listed[touches ? begin : end - 1];
    b.edges.push_back(
        {last.vertices, m.edge_refs[last.index], touches || listed[end - 1].named >= m.edges.size()});
  }
  const std::size_t known = b.edges.size();
  for (const Edge& edge : touching)
    if (!std::ranges::binary_search(std::span(b.edges).first(known), edge, {}, &BoundaryEdge::vertices))
      b.edges.push_back({edge, 0, 1});
}

void complete_edges(Peers& peers, const MeshData& m, const std::vector<Triangle>& outer, BoundaryShare& b) {
  std::uint64_t dropped = 0;
  std::vector<ListedEdge> listed;
  if (!m.edges.empty()) {
    const auto sides = sides_at_home(peers, b.triangles,
                                     [](const BoundaryTriangle& t) -> const Triangle& { return t.vertices; });
    listed = listed_edges(peers, m, sides, dropped);
  }
  const std::vector<Edge> touching = meshing::edges_of_several(
      sides_at_home(peers, outer, [](const Triangle& t) -> const Triangle& { return t; }));
  take_edges(m, listed, touching, b);
  const auto counts = partition::sum(peers, std::vector<std::uint64_t>{dropped, touching.size()});
  if (counts[0] > 0) b.warnings.push_back(meshing::dropped_edges_warning(counts[0]));
  if (counts[1] > 0) b.warnings.push_back(meshing::touching_edges_warning(counts[1]));
}

}  // namespace

BoundaryShare complete_boundary(Peers& peers, MeshSlice& slice, const PlacedTets& placed,
                                const Ranges& points, const Ranges& tets) {
  TriangleFindings findings;
  {
    const std::vector<FaceRecord> faces = meet_faces(peers, slice, placed, points);
    refuse_overused(peers, faces);
    refuse_overlaps(peers, slice, tets, faces);
    findings = match_triangles(peers, faces, slice.boundary.triangles);
  }
  MeshData whole = std::exchange(slice.boundary, {});
  BoundaryShare b;
  take_triangles(peers, whole, findings, tets, b);
  whole.triangles = {};
  whole.triangle_refs = {};
  complete_edges(peers, whole, findings.outer, b);
  b.corners = std::move(whole.corners);
  b.required_points = std::move(whole.required_points);
  return b;
}

}  // namespace weft::partition
