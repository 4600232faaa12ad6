// Classified once; then the share says by its references and edges what lies where.
#include "partition/surface/boundary_on_model.h"

#include <algorithm>
#include <span>
#include <utility>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "partition/communication/at_home.h"

namespace weft::partition {
namespace {

using meshing::EdgeOnModel;
using meshing::JointRef;

/// All ranks: the records of the vertices here, which any rank may have.
template <class Record>
std::vector<Record> records_here(Peers& peers, const std::vector<Record>& mine, const LocalSurface& local) {
  std::vector<std::vector<Record>> to_each(local.asked.size());
  for (const Record& r : mine) to_each[r.vertex % to_each.size()].push_back(r);
  std::vector<Record> at_home = all_to_all_joined(peers, std::move(to_each));
  std::ranges::sort(at_home, {}, &Record::vertex);
  std::vector<Record> here =
      told_at_home(peers, local.asked, std::move(at_home), [](const Record& r) { return r.vertex; });
  for (Record& r : here) r.vertex = static_cast<std::uint32_t>(meshing::place_in(local.vertices, r.vertex));
  return here;
}

/// All ranks: those of all ranks.
meshing::JointRefs joint_refs(Peers& peers, std::vector<JointRef> mine) {
  meshing::sort_unique(mine);
  return meshing::JointRefs(allgather_joined(peers, mine));
}

}  // namespace

BoundaryOnModel::BoundaryOnModel(Peers& peers, BoundaryShare& boundary, const FetchPoints& points,
                                 std::shared_ptr<const meshing::Model> model) {
  LocalSurface local = SurfaceNeighbours(peers, boundary, points).around(boundary.triangles);
  meshing::Association& records = local.mesh.association;
  records.nodes = records_here(peers, boundary.on_model.nodes, local);
  records.edges = records_here(peers, boundary.on_model.edges, local);
  records.faces = records_here(peers, boundary.on_model.faces, local);
  boundary.on_model = {};
  std::vector<std::uint32_t> own;
  for (const BoundaryTriangle& t : boundary.triangles) own.push_back(t.number);
  meshing::ModelClassification found =
      meshing::classify_on_model(BoundaryPart(peers, local, own), std::move(model));
  const std::vector<std::uint32_t> face_group = std::move(found.face_group);
  keep(peers, boundary, local, std::move(found));
  join_triangles(peers, face_group, boundary.triangles);
  join_edges(peers, boundary.edges);
}

void BoundaryOnModel::keep(Peers& peers, const BoundaryShare& boundary, const LocalSurface& local,
                           meshing::ModelClassification&& found) {
  for (const BoundaryTriangle& t : boundary.triangles) {
    const std::size_t place = meshing::place_in(local.triangles, t.number);
    faces_.push_back(found.triangle_face[place]);
    if (!found.parameters.empty()) parameters_.push_back(found.parameters[place]);
  }
  std::vector<Node> nodes;
  for (const auto& [vertex, node] : found.nodes) nodes.push_back({local.vertices[vertex], node});
  nodes_ = allgather_joined(peers, nodes);
  meshing::sort_unique(nodes_);
  edges_ = edges_sent_home(peers, local, std::move(found.edges));
  warnings_ = std::move(found.warnings);
  faults_ = found.faults;
}

void BoundaryOnModel::join_triangles(Peers& peers, const std::vector<std::uint32_t>& face_group,
                                     std::vector<BoundaryTriangle>& triangles) {
  const auto joint = [&](std::size_t i) {
    const std::uint32_t face = faces_[i];
    return JointRef{triangles[i].ref, face == meshing::kNoEntity ? meshing::kNoEntity : face_group[face]};
  };
  std::vector<JointRef> mine;
  for (std::size_t i = 0; i < faces_.size(); ++i) mine.push_back(joint(i));
  triangle_refs_ = joint_refs(peers, std::move(mine));
  for (std::size_t i = 0; i < faces_.size(); ++i) triangles[i].ref = triangle_refs_.number(joint(i));
}

/// At the homes of their lower vertices.
void BoundaryOnModel::join_edges(Peers& peers, std::vector<BoundaryEdge>& edges) {
  std::ranges::sort(edges, {}, &BoundaryEdge::vertices);
  const std::size_t listed = edges.size();
  for (const EdgeOnModel& e : edges_)
    if (!std::ranges::binary_search(std::span(edges).first(listed), e.vertices, {}, &BoundaryEdge::vertices))
      edges.push_back({e.vertices, 0, 0});
  std::vector<JointRef> refs;
  for (const BoundaryEdge& e : edges) {
    const EdgeOnModel* found = meshing::find_edge(edges_, e.vertices);
    refs.push_back({e.ref, found ? found->edge : meshing::kNoEntity});
  }
  edge_refs_ = joint_refs(peers, refs);
  for (std::size_t i = 0; i < refs.size(); ++i) edges[i].ref = edge_refs_.number(refs[i]);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> BoundaryOnModel::nodes(const LocalSurface& local) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> here;
  for (const Node& n : nodes_)
    if (std::ranges::binary_search(local.vertices, n.number))
      here.emplace_back(static_cast<std::uint32_t>(meshing::place_in(local.vertices, n.number)), n.node);
  return here;
}

meshing::KnownShapes BoundaryOnModel::known(const LocalSurface& local) const {
  meshing::KnownShapes known{triangle_refs_.on_model(), edge_refs_.on_model(), {}};
  for (const auto& [vertex, node] : nodes(local)) known.corners.push_back(vertex);
  return known;
}

}  // namespace weft::partition
