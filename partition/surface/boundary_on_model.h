// The boundary on a model, classified in shares.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "meshing/geometry/model/model_classification.h"
#include "meshing/geometry/surface/joint_refs.h"
#include "meshing/geometry/surface/surface_topology.h"
#include "partition/communication/peers.h"
#include "partition/surface/boundary_part.h"
#include "partition/surface/boundary_share.h"
#include "partition/surface/local_surface.h"

namespace weft::partition {

/// What meshing::classify_on_model() finds of the whole boundary, of each triangle at its owner: to the bit
/// the same for any number of ranks.
class BoundaryOnModel {
 public:
  /// `boundary`: the share that the rank owns, with triangles ascending. It becomes the share of which a
  /// surface on the model is built: with joint references, edges on the model's edges listed, and no records.
  /// All ranks call together, and throw alike.
  BoundaryOnModel(Peers& peers, BoundaryShare& boundary, const FetchPoints& points,
                  std::shared_ptr<const meshing::Model> model);

  meshing::KnownShapes known(const LocalSurface& local) const;
  const meshing::JointRefs& triangle_refs() const { return triangle_refs_; }
  const meshing::JointRefs& edge_refs() const { return edge_refs_; }

  // By triangles of the share:
  const std::vector<std::uint32_t>& faces() const { return faces_; }
  /// None, on all ranks, where all faces of the model have formulas.
  const std::vector<std::array<meshing::Parameters, 3>>& parameters() const { return parameters_; }

  /// (vertex, node) of vertices here, sorted.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> nodes(const LocalSurface& local) const;
  /// All ranks: edges between vertices here.
  std::vector<meshing::EdgeOnModel> edges(Peers& peers, const LocalSurface& local) const {
    return edges_between(peers, local, edges_);
  }

  // Of the whole boundary:
  const std::vector<std::string>& warnings() const { return warnings_; }
  const meshing::ModelFaults& faults() const { return faults_; }

 private:
  struct Node {
    std::uint32_t number, node;  ///< of the vertex in the whole input
    friend auto operator<=>(const Node&, const Node&) = default;
  };

  void keep(Peers& peers, const BoundaryShare& boundary, const LocalSurface& local,
            meshing::ModelClassification&& found);
  void join_triangles(Peers& peers, const std::vector<std::uint32_t>& face_group,
                      std::vector<BoundaryTriangle>& triangles);
  void join_edges(Peers& peers, std::vector<BoundaryEdge>& edges);

  meshing::JointRefs triangle_refs_, edge_refs_;
  std::vector<std::uint32_t> faces_;
  std::vector<std::array<meshing::Parameters, 3>> parameters_;
  std::vector<meshing::EdgeOnModel> edges_;  // whose lower vertex has its home here, by numbers, sorted
  std::vector<Node> nodes_;                  // all, sorted
  std::vector<std::string> warnings_;
  meshing::ModelFaults faults_;
};

}  // namespace weft::partition
