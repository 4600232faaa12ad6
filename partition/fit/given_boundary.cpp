// A triangle or an edge goes to the rank that has the point of its lowest vertex, and from there to all that
// have tets at this point.
#include "partition/fit/given_boundary.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/kernel/complete.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/tet_tables.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/surface/listed_entities.h"
#include "partition/surface/listed_points.h"

namespace weft::partition {
namespace {

using meshing::MeshData;
using meshing::TriangleSide;

using Ends = std::array<std::uint32_t, 2>;

struct GivenEdge {
  Ends vertices;  ///< as listed
  std::uint32_t number;
  std::int32_t ref;
  std::uint32_t ridge, required;  ///< 0 or 1
};

Ends ends_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

class GivenBoundary {
 public:
  GivenBoundary(Peers& peers, const MeshSlice& slice, std::span<const std::uint32_t> numbers,
                MeshPiece& piece)
      : peers_(peers),
        slice_(slice),
        numbers_(numbers),
        piece_(piece),
        ranges_(Ranges::of_arrays(peers, {slice.points.size(), slice.boundary.corners.size() +
                                                                   slice.boundary.required_points.size()})) {}

  bool take() {
    take_point_refs();
    own_points();
    bool complete = uses_all_points();
    std::vector<TriangleSide> sides;
    complete &= take_triangles(sides);
    const std::vector<GivenEdge> edges = given_edges();
    complete &= edges_are_complete_at_home(sides, edges);
    take_edges(edges);
    return partition::max(peers_, complete ? 0 : 1) == 0;
  }

 private:
  /// An entity where it has come to, and how the rank that it came from knows it.
  template <class Entity>
  struct Arrived {
    std::vector<Entity> at_points;                      ///< of the lowest vertices, here
    std::vector<std::vector<std::uint32_t>> handed_on;  ///< to each rank: which of them
    std::vector<std::vector<Entity>> at_tets;           ///< from each rank
  };

  std::uint32_t place_of(std::uint32_t number) const {
    const std::size_t place = meshing::place_in(numbers_, number);
    return place < numbers_.size() && numbers_[place] == number ? static_cast<std::uint32_t>(place) : kNone;
  }
  /// Their places here; empty where the piece lacks one.
  template <std::size_t N>
  std::optional<std::array<std::uint32_t, N>> places_of(const std::array<std::uint32_t, N>& vertices) const {
    std::array<std::uint32_t, N> places;
    for (std::size_t i = 0; i < N; ++i)
      if ((places[i] = place_of(vertices[i])) == kNone) return {};
    return places;
  }

  void take_point_refs() {
    const std::vector<std::uint32_t> numbers(numbers_.begin(), numbers_.end());
    piece_.mesh.point_refs =
        fetch<std::int32_t>(peers_, points_, numbers, [&](std::size_t i) { return slice_.point_refs[i]; });
  }

  /// Those of the slice, and which are listed.
  void own_points() {
    const std::uint64_t first = slice_.first_point, last = first + slice_.points.size();
    for (const std::uint32_t number : numbers_) piece_.own_points.push_back(number >= first && number < last);
    if (ranges_[1].total() == 0) return;
    const std::vector<std::uint32_t> numbers(numbers_.begin(), numbers_.end());
    take_listed_points(peers_, asked_at_home(peers_, numbers), listed_points_at_home(peers_, slice_.boundary),
                       numbers, piece_.mesh);
  }

  /// Others have a point for their tets' sake, or for an edge's, which must have a tet as well.
  bool uses_all_points() const {
    std::vector<std::uint8_t> used(numbers_.size(), 0);
    for (const auto& tet : piece_.mesh.tets)
      for (const std::uint32_t v : tet) used[v] = 1;
    for (const auto& [vertex, other] : piece_.shared) used[vertex] = 1;
    for (std::size_t v = 0; v < used.size(); ++v)
      if (piece_.own_points[v] && !used[v]) return false;
    return true;
  }

  template <class Entity>
  Arrived<Entity> bring_to_tets(const std::vector<Entity>& listed) {
    const auto ranks = static_cast<std::size_t>(peers_.ranks());
    std::vector<std::vector<Entity>> to_each(ranks);
    for (const Entity& e : listed) to_each[points_.rank_of(std::ranges::min(e.vertices))].push_back(e);
    Arrived<Entity> arrived{all_to_all_joined(peers_, std::move(to_each)), {}, {}};
    arrived.handed_on.resize(ranks);
    std::vector<std::vector<Entity>> on(ranks);
    for (std::uint32_t i = 0; i < arrived.at_points.size(); ++i) {
      const Entity& e = arrived.at_points[i];
      const auto hand_on = [&](std::size_t rank) {
        on[rank].push_back(e);
        arrived.handed_on[rank].push_back(i);
      };
      hand_on(static_cast<std::size_t>(peers_.rank()));
      const std::uint32_t place = place_of(std::ranges::min(e.vertices));
      for (const auto& holder :
           std::ranges::equal_range(piece_.shared, place, {}, &SubdomainStart::Shared::vertex))
        hand_on(holder.other.value);
    }
    arrived.at_tets = partition::all_to_all(peers_, std::move(on));
    return arrived;
  }

  /// A triangle whose vertices are all here.
  struct Candidate {
    std::array<std::uint32_t, 3> sorted, places;
    std::size_t rank, index;  ///< in Arrived::at_tets
    std::uint64_t code = 0;   ///< 4 times the first tet that has it, and its face there
    std::uint8_t sides = 0;   ///< how many tets here have it
  };

  std::vector<Candidate> candidates_of(const Arrived<BoundaryTriangle>& arrived) const {
    std::vector<Candidate> candidates;
    for (std::size_t r = 0; r < arrived.at_tets.size(); ++r)
      for (std::size_t i = 0; i < arrived.at_tets[r].size(); ++i) {
        const auto places = places_of(arrived.at_tets[r][i].vertices);
        if (!places) continue;
        auto sorted = *places;
        std::ranges::sort(sorted);
        candidates.push_back({sorted, *places, r, i});
      }
    std::ranges::sort(candidates, {},
                      [](const Candidate& c) { return std::tuple(c.sorted, c.rank, c.index); });
    return candidates;
  }

  /// Of triangles that are listed twice the first is found.
  void look_for_tets(std::vector<Candidate>& candidates) const {
    std::vector<std::uint8_t> on_triangle(numbers_.size(), 0);
    for (const Candidate& c : candidates)
      for (const std::uint32_t v : c.places) on_triangle[v] = 1;
    const auto& tets = piece_.mesh.tets;
    for (std::size_t t = 0; t < tets.size(); ++t)
      for (std::size_t f = 0; f < 4; ++f) {
        const auto& corners = meshing::kTetFaces[f];
        std::array<std::uint32_t, 3> face{tets[t][corners[0]], tets[t][corners[1]], tets[t][corners[2]]};
        if (!(on_triangle[face[0]] & on_triangle[face[1]] & on_triangle[face[2]])) continue;
        std::ranges::sort(face);
        const auto found = std::ranges::lower_bound(candidates, face, {}, &Candidate::sorted);
        if (found == candidates.end() || found->sorted != face) continue;
        if (found->sides == 0) found->code = 4 * t + f;
        found->sides = static_cast<std::uint8_t>(std::min(found->sides + 1, 3));
      }
  }

  /// Returns whether each triangle has one tet or two. Their sides, with what is known of outer ones, go into
  /// `sides`, each on one rank.
  bool take_triangles(std::vector<TriangleSide>& sides) {
    const Arrived<BoundaryTriangle> arrived = bring_to_tets(listed_triangles(peers_, slice_.boundary));
    std::vector<Candidate> candidates = candidates_of(arrived);
    look_for_tets(candidates);
    std::vector<std::vector<std::uint8_t>> found(arrived.at_tets.size());
    for (std::size_t r = 0; r < found.size(); ++r) found[r].assign(arrived.at_tets[r].size(), 0);
    for (const Candidate& c : candidates) found[c.rank][c.index] = c.sides;
    found = partition::all_to_all(peers_, std::move(found));
    std::vector<std::uint32_t> tets(arrived.at_points.size(), 0);
    for (std::size_t r = 0; r < found.size(); ++r)
      for (std::size_t i = 0; i < found[r].size(); ++i) tets[arrived.handed_on[r][i]] += found[r][i];
    bool complete = true;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      complete &= tets[t] == 1 || tets[t] == 2;
      const auto& v = arrived.at_points[t].vertices;
      for (std::size_t i = 0; i < 3; ++i) sides.push_back({ends_of(v[i], v[(i + 1) % 3]), tets[t] == 1});
    }
    std::erase_if(candidates, [](const Candidate& c) { return c.sides == 0; });
    std::ranges::sort(candidates, {}, &Candidate::code);
    MeshData& mesh = piece_.mesh;
    for (const Candidate& c : candidates) {
      const BoundaryTriangle& triangle = arrived.at_tets[c.rank][c.index];
      if (triangle.required)
        mesh.required_triangles.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
      mesh.triangles.push_back(c.places);
      mesh.triangle_refs.push_back(triangle.ref);
    }
    return complete;
  }

  /// Those of the slice, with their marks.
  std::vector<GivenEdge> given_edges() {
    const MeshData& m = slice_.boundary;
    const Ranges ranges(peers_, m.edges.size());
    std::vector<GivenEdge> edges;
    for (std::size_t e = 0; e < m.edges.size(); ++e)
      edges.push_back({m.edges[e], static_cast<std::uint32_t>(slice_.first_edge + e), m.edge_refs[e], 0, 0});
    for (const Named& named : named_here(peers_, ranges, m.ridges)) edges[named.place].ridge = 1;
    for (const Named& named : named_here(peers_, ranges, m.required_edges)) edges[named.place].required = 1;
    return edges;
  }

  /// All that have the same lower vertex meet.
  bool edges_are_complete_at_home(const std::vector<TriangleSide>& sides,
                                  const std::vector<GivenEdge>& edges) {
    const auto ranks = static_cast<std::size_t>(peers_.ranks());
    std::vector<std::vector<TriangleSide>> sides_to_each(ranks);
    std::vector<std::vector<Ends>> edges_to_each(ranks);
    for (const TriangleSide& side : sides) sides_to_each[side.vertices[0] % ranks].push_back(side);
    for (const GivenEdge& edge : edges) {
      const Ends ends = ends_of(edge.vertices[0], edge.vertices[1]);
      edges_to_each[ends[0] % ranks].push_back(ends);
    }
    return meshing::edges_are_complete(all_to_all_joined(peers_, std::move(sides_to_each)),
                                       all_to_all_joined(peers_, std::move(edges_to_each)));
  }

  /// The slice's own first, then those of others for whoever looks for the edges of tets.
  void take_edges(const std::vector<GivenEdge>& own) {
    for (const GivenEdge& edge : own) take_edge(edge, 1);
    const Arrived<GivenEdge> arrived = bring_to_tets(own);
    const std::uint64_t first = slice_.first_edge, last = first + own.size();
    for (const auto& of_rank : arrived.at_tets)
      for (const GivenEdge& edge : of_rank)
        if (edge.number < first || edge.number >= last) take_edge(edge, 0);
  }
  void take_edge(const GivenEdge& edge, std::uint8_t is_own) {
    const auto places = places_of(edge.vertices);
    if (!places) return;
    MeshData& mesh = piece_.mesh;
    const auto index = static_cast<std::uint32_t>(mesh.edges.size());
    mesh.edges.push_back(*places);
    mesh.edge_refs.push_back(edge.ref);
    if (edge.ridge) mesh.ridges.push_back(index);
    if (edge.required) mesh.required_edges.push_back(index);
    piece_.own_edges.push_back(is_own);
  }

  Peers& peers_;
  const MeshSlice& slice_;
  std::span<const std::uint32_t> numbers_;
  MeshPiece& piece_;
  const std::vector<Ranges> ranges_;  // of the points, and of those that are listed
  const Ranges& points_ = ranges_[0];
};

}  // namespace

bool take_given_boundary(Peers& peers, const MeshSlice& slice, std::span<const std::uint32_t> numbers,
                         MeshPiece& piece) {
  return GivenBoundary(peers, slice, numbers, piece).take();
}

}  // namespace weft::partition
