// Triangles are asked about at their owners, edges at the homes of their lower vertices.
#include "partition/surface/boundary_part.h"

#include <algorithm>
#include <utility>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "partition/communication/agreement.h"
#include "partition/communication/at_home.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/reduce.h"
#include "partition/communication/select.h"

namespace weft::partition {

using meshing::EdgeOnModel;
using meshing::FaceTally;
using meshing::FixedPointSum;
using meshing::NearVertex;

std::vector<EdgeOnModel> edges_sent_home(Peers& peers, const LocalSurface& local,
                                         std::vector<EdgeOnModel> edges) {
  std::vector<std::vector<EdgeOnModel>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (EdgeOnModel& e : edges) {
    for (std::uint32_t& v : e.vertices) v = local.vertices[v];
    to_each[e.vertices[0] % to_each.size()].push_back(e);
  }
  edges = all_to_all_joined(peers, std::move(to_each));
  meshing::sort_unique(edges, &EdgeOnModel::vertices);
  return edges;
}

std::vector<EdgeOnModel> edges_between(Peers& peers, const LocalSurface& local,
                                       const std::vector<EdgeOnModel>& at_home) {
  std::vector<EdgeOnModel> edges = told_between(peers, local.asked, local.vertices, at_home);
  for (EdgeOnModel& e : edges)
    for (std::uint32_t& v : e.vertices) v = static_cast<std::uint32_t>(meshing::place_in(local.vertices, v));
  std::ranges::sort(edges, {}, &EdgeOnModel::vertices);
  return edges;
}

std::uint32_t BoundaryPart::vertex(std::uint32_t number) const {
  if (!std::ranges::binary_search(local_.vertices, number)) return meshing::kNoEntity;
  return static_cast<std::uint32_t>(meshing::place_in(local_.vertices, number));
}

void BoundaryPart::run(const std::function<void()>& action) const { agree_on(peers_, action); }

std::vector<std::uint64_t> BoundaryPart::sum(std::vector<std::uint64_t> mine) const {
  return partition::sum(peers_, mine);
}

std::vector<FixedPointSum> BoundaryPart::sum(std::vector<FixedPointSum> mine) const {
  return added(peers_, mine);
}

std::vector<NearVertex> BoundaryPart::nearest(std::vector<NearVertex> mine) const {
  return partition::min(peers_, mine);
}

double BoundaryPart::max(double mine) const { return partition::max(peers_, mine); }

meshing::Box BoundaryPart::unite(const meshing::Box& mine) const { return common_box(peers_, mine); }

std::vector<double> BoundaryPart::select(std::vector<double> mine,
                                         std::span<const std::uint64_t> places) const {
  return partition::select(peers_, mine, places);
}

std::vector<FaceTally> BoundaryPart::all(std::vector<FaceTally> mine) const {
  return allgather_joined(peers_, mine);
}

std::vector<std::array<std::uint32_t, 2>> BoundaryPart::all(
    std::vector<std::array<std::uint32_t, 2>> mine) const {
  return allgather_joined(peers_, mine);
}

void BoundaryPart::refresh(std::vector<std::uint32_t>& of_triangles) const {
  of_triangles = from_owners<std::uint32_t>(peers_, local_, own_, [&](std::size_t i) {
    return of_triangles[meshing::place_in(local_.triangles, own_[i])];
  });
}

void BoundaryPart::refresh(std::vector<EdgeOnModel>& edges) const {
  edges = edges_between(peers_, local_, edges_sent_home(peers_, local_, std::move(edges)));
}

}  // namespace weft::partition
