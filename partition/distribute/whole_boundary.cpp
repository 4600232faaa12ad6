// The boundary's work of meshing::import_mesh, with faces matched across ranks.
#include "partition/distribute/whole_boundary.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

#include "meshing/base/error.h"
#include "meshing/base/place_in.h"
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
  std::vector<std::uint32_t> repeated;  ///< indices of triangles
  std::vector<Triangle> outer;          ///< of one tet
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
      if (covered) findings.repeated.push_back(triangle->index);
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

/// Copies the triangles without the repeated ones, and then those that were missing in the order of their
/// tets.
void take_triangles(const MeshData& m, std::vector<std::uint32_t> repeated, std::vector<Created> created,
                    WholeBoundary& b) {
  std::sort(repeated.begin(), repeated.end());
  std::sort(created.begin(), created.end(),
            [](const Created& x, const Created& y) { return x.code < y.code; });
  std::vector<std::uint32_t> new_index(m.triangles.size(), meshing::kDropped);
  for (std::uint32_t i = 0; i < m.triangles.size(); ++i) {
    if (std::binary_search(repeated.begin(), repeated.end(), i)) continue;
    new_index[i] = static_cast<std::uint32_t>(b.data.triangles.size());
    b.data.triangles.push_back(m.triangles[i]);
    b.data.triangle_refs.push_back(m.triangle_refs[i]);
  }
  if (!repeated.empty()) b.warnings.push_back(meshing::repeated_triangles_warning(repeated.size()));
  meshing::take_required_triangles(m, new_index, b.data);
  for (const Created& c : created) {
    b.data.triangles.push_back(c.vertices);
    b.data.triangle_refs.push_back(0);
  }
  if (!created.empty()) b.warnings.push_back(meshing::created_triangles_warning(created.size()));
}

/// Renumbers by the points that occur, in their order, so that whatever goes by order stays as it is.
void compress(WholeBoundary& b) {
  MeshData& d = b.data;
  for (const Triangle& t : d.triangles) b.numbers.insert(b.numbers.end(), t.begin(), t.end());
  for (const auto* list : {&d.corners, &d.required_points})
    b.numbers.insert(b.numbers.end(), list->begin(), list->end());
  std::sort(b.numbers.begin(), b.numbers.end());
  b.numbers.erase(std::unique(b.numbers.begin(), b.numbers.end()), b.numbers.end());
  const auto renumber = [&](std::span<std::uint32_t> vertices) {
    for (std::uint32_t& v : vertices) v = static_cast<std::uint32_t>(meshing::place_in(b.numbers, v));
  };
  for (auto& t : d.triangles) renumber(t);
  for (auto& e : d.edges) renumber(e);
  renumber(d.corners);
  renumber(d.required_points);
}

/// Every rank contributes the points of its share.
void gather_points(Peers& peers, const MeshSlice& slice, const Ranges& points, WholeBoundary& b) {
  const auto begin = std::lower_bound(b.numbers.begin(), b.numbers.end(), points.first(peers.rank()));
  const auto end = std::lower_bound(begin, b.numbers.end(), points.first(peers.rank() + 1));
  std::vector<meshing::Point> mine;
  for (auto number = begin; number != end; ++number)
    mine.push_back(slice.points[*number - slice.first_point]);
  b.data.points = allgather_joined(peers, mine);
}

}  // namespace

WholeBoundary complete_boundary(Peers& peers, const MeshSlice& slice, const PlacedTets& placed,
                                const Ranges& points, const Ranges& tets) {
  TriangleFindings findings;
  {
    const std::vector<FaceRecord> faces = meet_faces(peers, slice, placed, points);
    refuse_overused(peers, faces);
    refuse_overlaps(peers, slice, tets, faces);
    findings = match_triangles(peers, faces, slice.boundary.triangles);
  }
  WholeBoundary b;
  b.data.corners = slice.boundary.corners;
  b.data.required_points = slice.boundary.required_points;
  take_triangles(slice.boundary, allgather_joined(peers, findings.repeated),
                 allgather_joined(peers, findings.created), b);
  meshing::take_boundary_edges(slice.boundary, b.data, b.warnings);
  const std::size_t touching =
      meshing::require_touching_edges(allgather_joined(peers, findings.outer), b.data);
  if (touching > 0) b.warnings.push_back(meshing::touching_edges_warning(touching));
  compress(b);
  gather_points(peers, slice, points, b);
  return b;
}

}  // namespace weft::partition
