// Meshes cut into pieces, and the pieces dealt out to ranks.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"
#include "partition/output/merge_pieces.h"
#include "partition/subdomain/mesh_piece.h"
#include "tests/partition/communication/barrier_peers.h"
#include "tests/support/meshes.h"

namespace weft::partition {

inline constexpr int kRankCounts[] = {1, 2, 3, 4, 8};

inline std::vector<SubdomainId> subdomain_ids(std::initializer_list<std::uint32_t> numbers) {
  return {numbers.begin(), numbers.end()};
}

/// Cuts a mesh by the subdomain of each tet. Slow and simple: each piece takes of every kind of entity those
/// that a tet of it has.
class Cutter {
 public:
  Cutter(const MergedMesh& whole, const std::vector<SubdomainId>& subdomain_of_tet, std::uint32_t num_pieces)
      : whole_(whole), pieces_(num_pieces), numbers_(num_pieces), subdomain_of_tet_(subdomain_of_tet) {
    for (SubdomainId s(0); s.value < num_pieces; ++s.value) pieces_[s.value].subdomain = s;
  }

  std::vector<MeshPiece> cut() {
    take_points();
    const meshing::MeshData& mesh = whole_.mesh;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      take(mesh.tets[t], subdomain_of_tet_[t], &meshing::MeshData::tets);
      pieces_[subdomain_of_tet_[t].value].mesh.tet_refs.push_back(mesh.tet_refs[t]);
    }
    take_with_marks(mesh.triangles, mesh.triangle_refs,
                    {{&mesh.required_triangles, &meshing::MeshData::required_triangles}},
                    &meshing::MeshData::triangles, &meshing::MeshData::triangle_refs);
    take_with_marks(mesh.edges, mesh.edge_refs,
                    {{&mesh.ridges, &meshing::MeshData::ridges},
                     {&mesh.required_edges, &meshing::MeshData::required_edges}},
                    &meshing::MeshData::edges, &meshing::MeshData::edge_refs);
    take_point_list(mesh.corners, &meshing::MeshData::corners);
    take_point_list(mesh.required_points, &meshing::MeshData::required_points);
    return std::move(pieces_);
  }

 private:
  using MeshData = meshing::MeshData;
  using List = std::vector<std::uint32_t>;

  void take_points() {
    std::vector<std::set<SubdomainId>> holders(whole_.mesh.points.size());
    for (std::size_t t = 0; t < whole_.mesh.tets.size(); ++t)
      for (const std::uint32_t v : whole_.mesh.tets[t]) holders[v].insert(subdomain_of_tet_[t]);
    for (std::uint32_t v = 0; v < holders.size(); ++v)
      for (const SubdomainId s : holders[v]) take_point(v, s, holders[v]);
  }

  void take_point(std::uint32_t v, SubdomainId s, const std::set<SubdomainId>& holders) {
    MeshPiece& piece = pieces_[s.value];
    const auto local = static_cast<std::uint32_t>(piece.mesh.points.size());
    numbers_[s.value][v] = local;
    piece.mesh.points.push_back(whole_.mesh.points[v]);
    piece.mesh.point_refs.push_back(whole_.mesh.point_refs[v]);
    piece.log_metrics.push_back(whole_.log_metrics[v]);
    piece.ids.emplace_back(*holders.begin(), v);
    for (const SubdomainId other : holders)
      if (other != s) piece.shared.push_back({local, other});
  }

  template <std::size_t N>
  void take(const std::array<std::uint32_t, N>& entity, SubdomainId s,
            std::vector<std::array<std::uint32_t, N>> MeshData::*list) {
    std::array<std::uint32_t, N> local;
    for (std::size_t i = 0; i < N; ++i) local[i] = numbers_[s.value].at(entity[i]);
    (pieces_[s.value].mesh.*list).push_back(local);
  }

  /// The subdomains that have a tet with all these vertices.
  template <std::size_t N>
  std::set<SubdomainId> holders_of(std::array<std::uint32_t, N> entity) {
    if (tets_of_point_.empty())
      for (std::uint32_t t = 0; t < whole_.mesh.tets.size(); ++t)
        for (const std::uint32_t v : whole_.mesh.tets[t]) tets_of_point_[v].push_back(t);
    std::set<SubdomainId> holders;
    for (const std::uint32_t t : tets_of_point_[entity[0]]) {
      const auto& tet = whole_.mesh.tets[t];
      const bool has_all = std::all_of(entity.begin(), entity.end(), [&](std::uint32_t v) {
        return std::find(tet.begin(), tet.end(), v) != tet.end();
      });
      if (has_all) holders.insert(subdomain_of_tet_[t]);
    }
    return holders;
  }

  template <std::size_t N>
  void take_with_marks(const std::vector<std::array<std::uint32_t, N>>& entities,
                       const std::vector<std::int32_t>& refs,
                       const std::vector<std::pair<const List*, List MeshData::*>>& marks,
                       std::vector<std::array<std::uint32_t, N>> MeshData::*list,
                       std::vector<std::int32_t> MeshData::*ref_list) {
    std::vector<std::map<std::uint32_t, std::uint32_t>> numbers(pieces_.size());
    for (std::uint32_t e = 0; e < entities.size(); ++e)
      for (const SubdomainId s : holders_of(entities[e])) {
        numbers[s.value][e] = static_cast<std::uint32_t>((pieces_[s.value].mesh.*list).size());
        take(entities[e], s, list);
        (pieces_[s.value].mesh.*ref_list).push_back(refs[e]);
      }
    for (const auto& [marked, mark_list] : marks)
      for (const std::uint32_t e : *marked)
        for (std::size_t s = 0; s < pieces_.size(); ++s)
          if (numbers[s].contains(e)) (pieces_[s].mesh.*mark_list).push_back(numbers[s][e]);
  }

  void take_point_list(const List& points, List MeshData::*list) {
    for (const std::uint32_t v : points)
      for (std::size_t s = 0; s < pieces_.size(); ++s)
        if (numbers_[s].contains(v)) (pieces_[s].mesh.*list).push_back(numbers_[s][v]);
  }

  const MergedMesh& whole_;
  std::vector<MeshPiece> pieces_;
  std::vector<std::map<std::uint32_t, std::uint32_t>> numbers_;  ///< of each piece: whole -> local
  const std::vector<SubdomainId>& subdomain_of_tet_;
  std::map<std::uint32_t, std::vector<std::uint32_t>> tets_of_point_;
};

/// A box of two materials with jittered points, edges, marks of all kinds and a metric that varies.
inline MergedMesh random_mesh(unsigned seed) {
  std::mt19937 random(seed);
  MergedMesh whole{support::unit_cube(2 + random() % 4), {}};
  meshing::MeshData& mesh = whole.mesh;
  support::jitter_interior(mesh, 0.03, seed);
  support::shuffle(mesh, seed);
  const auto some = [&](std::size_t n, std::vector<std::uint32_t>& list) {
    for (std::uint32_t i = 0; i < n; ++i)
      if (random() % 5 == 0) list.push_back(i);
    std::shuffle(list.begin(), list.end(), random);
  };
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double x = 0;
    for (const std::uint32_t v : mesh.tets[t]) x += mesh.points[v].x / 4;
    mesh.tet_refs[t] = x < 0.5 ? 1 : 2;
  }
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  support::add_boundary_triangles(mesh);
  for (std::int32_t& ref : mesh.point_refs) ref = static_cast<std::int32_t>(random() % 3);
  mesh.edges.clear();
  mesh.edge_refs.clear();
  std::set<std::array<std::uint32_t, 2>> edges;
  for (const auto& tet : mesh.tets)
    if (random() % 4 == 0) edges.insert({std::min(tet[0], tet[1]), std::max(tet[0], tet[1])});
  for (const auto& edge : edges) {
    mesh.edges.push_back(edge);
    mesh.edge_refs.push_back(static_cast<std::int32_t>(random() % 4));
  }
  for (auto* list :
       {&mesh.corners, &mesh.ridges, &mesh.required_points, &mesh.required_edges, &mesh.required_triangles})
    list->clear();
  some(mesh.points.size(), mesh.corners);
  some(mesh.points.size(), mesh.required_points);
  some(mesh.edges.size(), mesh.ridges);
  some(mesh.edges.size(), mesh.required_edges);
  some(mesh.triangles.size(), mesh.required_triangles);
  whole.log_metrics = meshing::sample(meshing::AnalyticMetric("polar-1"), mesh);
  return whole;
}

/// A subdomain for every tet: of the nearest of `num_pieces` random places, or all at random.
inline std::vector<SubdomainId> random_subdomains(const meshing::MeshData& mesh, std::uint32_t num_pieces,
                                                  bool scattered, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<meshing::Point> places(num_pieces);
  for (meshing::Point& place : places) place = {unit(random), unit(random), unit(random)};
  std::vector<SubdomainId> subdomains;
  for (const auto& tet : mesh.tets) {
    meshing::Point centre;
    for (const std::uint32_t v : tet) centre += 0.25 * mesh.points[v];
    const auto nearest = std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
      return norm2(a - centre) < norm2(b - centre);
    });
    subdomains.push_back(scattered ? SubdomainId(static_cast<std::uint32_t>(random() % num_pieces))
                                   : SubdomainId(static_cast<std::uint32_t>(nearest - places.begin())));
  }
  return subdomains;
}

/// A random mesh cut into pieces; the last one has no tet.
struct CutMesh {
  MergedMesh whole;
  std::vector<MeshPiece> pieces;
};
inline CutMesh random_cut(unsigned seed) {
  CutMesh cut{random_mesh(seed), {}};
  const std::uint32_t num_pieces = 1 + seed % 7;
  const auto subdomains = random_subdomains(cut.whole.mesh, num_pieces, seed % 3 == 0, seed);
  cut.pieces = Cutter(cut.whole, subdomains, num_pieces + 1).cut();
  return cut;
}

/// Which pieces each rank gets, in any order.
inline std::vector<std::vector<MeshPiece>> deal(const std::vector<MeshPiece>& pieces, int ranks,
                                                unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<std::vector<MeshPiece>> hands(static_cast<std::size_t>(ranks));
  for (const MeshPiece& piece : pieces) {
    auto& hand = hands[random() % hands.size()];
    hand.insert(hand.begin() + static_cast<std::ptrdiff_t>(random() % (hand.size() + 1)), piece);
  }
  return hands;
}

}  // namespace weft::partition
