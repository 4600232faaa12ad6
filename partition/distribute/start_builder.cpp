// From records to the arrays of a subdomain.
#include "partition/distribute/start_builder.h"

#include <algorithm>
#include <utility>

#include "meshing/mesh/compact_order.h"
#include "meshing/mesh/tet_tables.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/subdomain/background_store.h"

namespace weft::partition {
namespace {

constexpr std::uint32_t kNone = BoundaryIndex::kNone;

class StartBuilder {
 public:
  StartBuilder(std::span<const TetRecord> tets, const BoundaryIndex& boundary)
      : tets_(tets), boundary_(boundary), numbers_(vertices_of(tets)) {}

  SubdomainStart build(SubdomainId subdomain, std::span<const PointRecord> points, const Holders& holders,
                       bool compact) {
    start_.subdomain = subdomain;
    add_vertices(points);
    add_names(holders);
    add_tets(compact);
    for (std::uint32_t t = 0; t < tets_.size(); ++t) add_boundary(t);
    auto& edges = start_.feature_edges;
    std::sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) { return a.ends < b.ends; });
    edges.erase(std::unique(edges.begin(), edges.end(),
                            [](const auto& a, const auto& b) { return a.ends == b.ends; }),
                edges.end());
    return std::move(start_);
  }

 private:
  void add_vertices(std::span<const PointRecord> points);
  void add_names(const Holders& holders);
  void add_tets(bool compact);
  void add_boundary(std::uint32_t t);

  std::span<const TetRecord> tets_;
  const BoundaryIndex& boundary_;
  std::vector<std::uint32_t> numbers_;  // of the vertices in the input, ascending
  std::vector<std::uint32_t> known_;    // their places in the index
  SubdomainStart start_;
};

void StartBuilder::add_vertices(std::span<const PointRecord> points) {
  auto point = points.begin();
  for (const std::uint32_t number : numbers_) {
    if (point->number != number)  // mostly the next one
      point = std::ranges::lower_bound(point, points.end(), number, {}, &PointRecord::number);
    const std::uint32_t known = boundary_.vertex(number);
    start_.points.push_back(point->point);
    start_.point_refs.push_back(point->ref);
    start_.log_metrics.push_back(point->log_metric);
    start_.kinds.push_back(known == kNone ? meshing::VertexKind::interior : boundary_.kind(known));
    start_.flags.push_back(known == kNone ? 0 : boundary_.flags(known));
    start_.surface_hints.push_back(known == kNone ? kNone : boundary_.hint(known));
    known_.push_back(known);
    if (point + 1 != points.end()) ++point;
  }
}

void StartBuilder::add_names(const Holders& holders) {
  for (std::uint32_t v = 0; v < numbers_.size(); ++v) {
    const auto all = holders.of(numbers_[v]);
    start_.ids.emplace_back(all.empty() ? start_.subdomain : all.front().subdomain, numbers_[v]);
    for (const InputHolder& holder : all)
      if (holder.subdomain != start_.subdomain) start_.shared.push_back({v, holder.subdomain});
  }
}

void StartBuilder::add_tets(bool compact) {
  PlacesOfNumbers places(numbers_);
  std::vector<std::array<std::uint32_t, 4>> tets;
  tets.reserve(tets_.size());
  for (const TetRecord& tet : tets_) tets.push_back(places(tet.vertices));
  start_.tet_refs.reserve(tets_.size());
  if (compact) {
    for (const TetRecord& tet : tets_) start_.tet_refs.push_back(tet.ref);
    start_.tets = std::move(tets);
    return;
  }
  start_.tets.reserve(tets_.size());
  for (const std::uint32_t t : meshing::compact_order(start_.points, tets, kTetsOfPiece)) {
    start_.tets.push_back(tets[t]);
    start_.tet_refs.push_back(tets_[t].ref);
  }
}

/// The patches of a tet's faces and the curves of its edges.
void StartBuilder::add_boundary(std::uint32_t t) {
  const auto& tet = start_.tets[t];
  const auto known = [&](int i) { return known_[tet[i]]; };
  const auto is_known = [&](std::uint32_t v) { return known_[v] != kNone; };
  if (std::ranges::count_if(tet, is_known) < 2) return;  // as nearly all
  const auto number = [&](int i) { return numbers_[tet[i]]; };
  for (std::uint32_t f = 0; f < 4; ++f) {
    const auto& face = meshing::kTetFaces[f];
    if (std::ranges::any_of(face, [&](int i) { return known(i) == kNone; })) continue;
    if (const meshing::PatchId patch = boundary_.patch({number(face[0]), number(face[1]), number(face[2])});
        patch.valid())
      start_.boundary_faces.push_back({t, f, patch});
  }
  const auto on_feature = [&](int i) { return start_.kinds[tet[i]] >= meshing::VertexKind::ridge; };
  for (const auto& edge : meshing::kTetEdges) {
    if (!on_feature(edge[0]) || !on_feature(edge[1])) continue;
    const meshing::CurveId curve = boundary_.curve(number(edge[0]), number(edge[1]));
    if (!curve.valid()) continue;
    const auto [a, b] = std::minmax(tet[edge[0]], tet[edge[1]]);
    start_.feature_edges.push_back({{a, b}, curve});
  }
}

}  // namespace

SubdomainStart build_start(SubdomainId subdomain, std::span<const TetRecord> tets,
                           std::span<const PointRecord> points, const Holders& holders,
                           const BoundaryIndex& boundary, bool compact) {
  return StartBuilder(tets, boundary).build(subdomain, points, holders, compact);
}

}  // namespace weft::partition
