// The boundary's work of meshing::import_mesh, with faces matched across ranks.
#include "partition/surface/boundary_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/base/release.h"
#include "meshing/base/sort_unique.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/boundary_entities.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/touching_edges.h"
#include "partition/communication/input_issue.h"
#include "partition/communication/reduce.h"
#include "partition/surface/face_records.h"
#include "partition/surface/listed_entities.h"

namespace weft::partition {
namespace {

using meshing::MeshData;
using meshing::Tet;
using meshing::Triangle;

enum VertexMark : std::uint8_t {
  kUsedElsewhere = 1,  ///< tets of other ranks have the vertex too
  kOnTriangle = 2,     ///< a triangle of any rank has it
};

/// All ranks: the marks of these vertices. Whoever has the point knows who has the vertex.
std::vector<std::uint8_t> vertex_marks(Peers& peers, const Ranges& points,
                                       const std::vector<std::uint32_t>& numbers,
                                       const std::vector<Triangle>& triangles) {
  const std::uint64_t first = points.first(peers.rank());
  std::vector<std::uint8_t> users(points.first(peers.rank() + 1) - first, 0), marks(users.size(), 0);
  {
    std::vector<std::uint32_t> corners;
    for (const Triangle& t : triangles) corners.insert(corners.end(), t.begin(), t.end());
    meshing::sort_unique(corners);
    for (const auto& of_rank : sent_to_owners(peers, points, corners))
      for (const std::uint32_t number : of_rank) marks[number - first] = kOnTriangle;
  }
  const auto asked = sent_to_owners(peers, points, numbers);
  for (const auto& of_rank : asked)
    for (const std::uint32_t number : of_rank)
      if (std::uint8_t& known = users[number - first]; known < 2 && ++known == 2)
        marks[number - first] |= kUsedElsewhere;
  std::vector<std::vector<std::uint8_t>> answers(asked.size());
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const std::uint32_t number : asked[r]) answers[r].push_back(marks[number - first]);
  return all_to_all_joined(peers, std::move(answers));
}

/// The faces of the slice, of which those that have both their tets here are mostly nobody else's business.
class SliceFaces {
 public:
  /// All ranks call together.
  SliceFaces(Peers& peers, const MeshSlice& slice, const PlacedTets& placed, const Ranges& points)
      : slice_(slice),
        tets_(placed.tets),
        marks_(vertex_marks(peers, points, placed.numbers, slice.boundary.triangles)) {
    try {
      meshing::Adjacency adjacency = meshing::build_adjacency(tets_, placed.numbers.size());
      neighbours_ = std::move(adjacency.neighbours);
      turns_differ_ = adjacency.turns_differ;
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
    const Triangle mine = corners(t, f);
    if (marks_[mine[0]] & marks_[mine[1]] & marks_[mine[2]]) return true;
    return !turns_differ_ && turns_alike(mine, corners(code >> 2, code & 3));
  }

 private:
  static bool turns_alike(const Triangle& mine, const Triangle& other) {
    const auto at = static_cast<std::size_t>(std::ranges::find(other, mine[0]) - other.begin());
    return other[(at + 1) % 3] == mine[1];
  }
  Triangle corners(std::uint32_t t, std::size_t f) const {
    const auto& c = meshing::kTetFaces[f];
    return {tets_[t][c[0]], tets_[t][c[1]], tets_[t][c[2]]};
  }

  const MeshSlice& slice_;
  std::span<const Tet> tets_;
  std::vector<std::uint8_t> marks_;  ///< of vertices
  std::vector<Tet> neighbours_;      ///< empty: not known
  bool turns_differ_ = true;         ///< as in meshing::Adjacency
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
  std::vector<BoundaryTriangle> kept;   ///< numbered as in the input
  std::vector<std::uint32_t> repeated;  ///< numbers in the input
  std::vector<Triangle> outer;          ///< of one tet
  std::vector<Created> created;
};

struct SortedTriangle {
  Triangle sorted;
  BoundaryTriangle triangle;  ///< numbered as in the input
};

/// All ranks: triangles whose lowest vertex is this rank's, by vertices and then as they are numbered.
std::vector<SortedTriangle> triangles_at_home(Peers& peers, const MeshData& m) {
  std::vector<std::vector<SortedTriangle>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (const BoundaryTriangle& t : listed_triangles(peers, m)) {
    Triangle sorted = t.vertices;
    std::ranges::sort(sorted);
    to_each[sorted[0] % to_each.size()].push_back({sorted, t});
  }
  std::vector<SortedTriangle> mine = all_to_all_joined(peers, std::move(to_each));
  std::ranges::sort(mine, {}, [](const SortedTriangle& t) { return std::pair{t.sorted, t.triangle.number}; });
  return mine;
}

InputIssue no_face(const BoundaryTriangle& t) {
  return {{t.number, 0, 0}, meshing::triangle_name(t.number, t.vertices), meshing::kIsNoFace};
}

/// Walks through faces and triangles, both sorted by vertices.
TriangleFindings match_triangles(Peers& peers, const std::vector<FaceRecord>& faces,
                                 const std::vector<SortedTriangle>& mine) {
  TriangleFindings findings;
  std::optional<InputIssue> first;
  auto triangle = mine.begin();
  const auto pass_strangers = [&](const Triangle* face) {
    for (; triangle != mine.end() && (!face || triangle->sorted < *face); ++triangle)
      keep_least(first, no_face(triangle->triangle));
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
    for (; triangle != mine.end() && triangle->sorted == face.vertices; ++triangle) {
      if (covered)
        findings.repeated.push_back(triangle->triangle.number);
      else
        findings.kept.push_back(triangle->triangle);
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

/// The triangles, of `num_triangles` listed, without the repeated ones, and then those that were missing.
void take_triangles(Peers& peers, std::uint64_t num_triangles, TriangleFindings& findings, const Ranges& tets,
                    BoundaryShare& b) {
  std::vector<std::uint32_t> repeated = allgather_joined(peers, findings.repeated);
  std::ranges::sort(repeated);
  b.triangles = std::exchange(findings.kept, {});
  for (BoundaryTriangle& t : b.triangles)
    t.number -= static_cast<std::uint32_t>(std::ranges::lower_bound(repeated, t.number) - repeated.begin());
  if (!repeated.empty()) b.warnings.push_back(meshing::repeated_triangles_warning(repeated.size()));
  const std::vector<Created> created = in_order_of_tets(peers, tets, findings.created);
  const Ranges numbers(peers, created.size());
  const std::uint64_t first = num_triangles - repeated.size() + numbers.first(peers.rank());
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

/// A listed edge, and when the lists name it: edges in their order, then required ones in theirs.
struct ListedEdge {
  Edge vertices;
  std::uint64_t named;
  std::int64_t ref;  ///< as wide as the rest: records travel as plain bytes, without padding
};

/// All ranks: edges whose home this rank is and that are sides, by vertices and then as they are named.
/// Counts the others.
std::vector<ListedEdge> listed_edges(Peers& peers, const MeshData& m, const std::vector<Edge>& sides,
                                     std::uint64_t& dropped) {
  const Ranges ranges(peers, m.edges.size());
  std::vector<std::vector<ListedEdge>> to_each(static_cast<std::size_t>(peers.ranks()));
  const auto send = [&](std::size_t e, std::uint64_t named) {
    const Edge edge = edge_of(m.edges[e][0], m.edges[e][1]);
    to_each[edge[0] % to_each.size()].push_back({edge, named, m.edge_refs[e]});
  };
  for (std::size_t e = 0; e < m.edges.size(); ++e) send(e, ranges.first(peers.rank()) + e);
  for (const Named& named : named_here(peers, ranges, m.required_edges))
    send(named.place, ranges.total() + named.in_list);
  std::vector<ListedEdge> listed = all_to_all_joined(peers, std::move(to_each));
  std::erase_if(listed, [&](const ListedEdge& e) {
    if (std::ranges::binary_search(sides, e.vertices)) return false;
    dropped += e.named < ranges.total();
    return true;
  });
  std::ranges::sort(listed, {}, [](const ListedEdge& e) { return std::pair{e.vertices, e.named}; });
  return listed;
}

/// Each of `num_edges` once. What is named last counts; of edges at which the mesh touches itself, what is
/// listed first.
void take_edges(std::uint64_t num_edges, std::span<const ListedEdge> listed, std::span<const Edge> touching,
                BoundaryShare& b) {
  for (std::size_t begin = 0, end = 0; begin < listed.size(); begin = end) {
    while (end < listed.size() && listed[end].vertices == listed[begin].vertices) ++end;
    const bool touches = std::ranges::binary_search(touching, listed[begin].vertices);
    const ListedEdge& last = listed[touches ? begin : end - 1];
    b.edges.push_back(
        {last.vertices, static_cast<std::int32_t>(last.ref), touches || listed[end - 1].named >= num_edges});
  }
  const std::size_t known = b.edges.size();
  for (const Edge& edge : touching)
    if (!std::ranges::binary_search(std::span(b.edges).first(known), edge, {}, &BoundaryEdge::vertices))
      b.edges.push_back({edge, 0, 1});
}

/// All ranks: edges, and the lists of points.
void complete_lists(Peers& peers, std::uint64_t num_edges, const MeshData& m,
                    const std::vector<Triangle>& outer, BoundaryShare& b) {
  std::uint64_t dropped = 0;
  std::vector<ListedEdge> listed;
  if (num_edges > 0) {
    const auto sides = sides_at_home(peers, b.triangles,
                                     [](const BoundaryTriangle& t) -> const Triangle& { return t.vertices; });
    listed = listed_edges(peers, m, sides, dropped);
  }
  const std::vector<Edge> touching = meshing::edges_of_several(
      sides_at_home(peers, outer, [](const Triangle& t) -> const Triangle& { return t; }));
  take_edges(num_edges, listed, touching, b);
  const std::uint64_t points = m.corners.size() + m.required_points.size();
  const auto counts = partition::sum(peers, std::vector<std::uint64_t>{dropped, touching.size(), points});
  if (counts[0] > 0) b.warnings.push_back(meshing::dropped_edges_warning(counts[0]));
  if (counts[1] > 0) b.warnings.push_back(meshing::touching_edges_warning(counts[1]));
  b.any_listed_points = counts[2] > 0;
  if (b.any_listed_points) b.listed_points = listed_points_at_home(peers, m);
}

/// In the words in which the topology of a surface refuses them: that of a share would do so on one rank
/// alone, and count the triangles there.
void refuse_collapsed(Peers& peers, const std::vector<BoundaryTriangle>& triangles) {
  std::optional<InputIssue> first;
  for (const BoundaryTriangle& t : triangles) {
    const auto& [a, b, c] = t.vertices;
    if (a == b || b == c || c == a)
      keep_least(
          first,
          {{t.number, 0, 0}, fmt::format("triangle {}", std::uint64_t{t.number} + 1), "has a vertex twice"});
  }
  throw_first(peers, first);
}

}  // namespace

BoundaryShare complete_boundary(Peers& peers, MeshSlice& slice, const PlacedTets& placed,
                                const Ranges& points, const Ranges& tets) {
  TriangleFindings findings;
  MeshData mine;
  {
    const std::vector<FaceRecord> faces = meet_faces(peers, slice, placed, points);
    refuse_overused(peers, faces);
    refuse_overlaps(peers, slice, tets, faces);
    mine = std::exchange(slice.boundary, {});
    const std::vector<SortedTriangle> triangles = triangles_at_home(peers, mine);
    meshing::release(mine.triangles);
    meshing::release(mine.triangle_refs);
    findings = match_triangles(peers, faces, triangles);
  }
  BoundaryShare b;
  take_triangles(peers, slice.num_triangles, findings, tets, b);
  complete_lists(peers, slice.num_edges, mine, findings.outer, b);
  b.on_model = std::move(mine.association);
  return b;
}

BoundaryShare listed_boundary(Peers& peers, const MeshSlice& slice) {
  BoundaryShare b;
  b.triangles = listed_triangles(peers, slice.boundary);
  refuse_collapsed(peers, b.triangles);
  complete_lists(peers, slice.num_edges, slice.boundary, {}, b);
  b.on_model = slice.boundary.association;
  return b;
}

}  // namespace weft::partition
