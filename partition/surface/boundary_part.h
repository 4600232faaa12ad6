// A share of the boundary with the triangles around it, as what is classified on a model.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "meshing/geometry/model/boundary_domain.h"
#include "partition/communication/peers.h"
#include "partition/surface/local_surface.h"

namespace weft::partition {

/// All ranks: edges between vertices of `local`, of which several ranks may have the same, each once at the
/// home of its lower vertex; sorted, numbered as in the whole input.
std::vector<meshing::EdgeOnModel> edges_sent_home(Peers& peers, const LocalSurface& local,
                                                  std::vector<meshing::EdgeOnModel> edges);
/// All ranks: of those at their homes what lies between vertices of `local`; sorted, numbered as there.
std::vector<meshing::EdgeOnModel> edges_between(Peers& peers, const LocalSurface& local,
                                                const std::vector<meshing::EdgeOnModel>& at_home);

class BoundaryPart final : public meshing::BoundaryDomain {
 public:
  /// Each rank owns the triangles with these numbers, ascending. Refers to its arguments.
  BoundaryPart(Peers& peers, const LocalSurface& local, std::span<const std::uint32_t> own)
      : peers_(peers), local_(local), own_(own) {}

  const meshing::MeshData& mesh() const override { return local_.mesh; }
  bool owns(std::size_t triangle) const override {
    return local_.rings.empty() || local_.rings[triangle] == 0;
  }
  std::uint32_t number(std::uint32_t vertex) const override { return local_.vertices[vertex]; }
  std::uint32_t vertex(std::uint32_t number) const override;
  void run(const std::function<void()>& action) const override;
  std::vector<std::uint64_t> sum(std::vector<std::uint64_t> mine) const override;
  std::vector<meshing::FixedPointSum> sum(std::vector<meshing::FixedPointSum> mine) const override;
  std::vector<meshing::NearVertex> nearest(std::vector<meshing::NearVertex> mine) const override;
  double max(double mine) const override;
  meshing::Box unite(const meshing::Box& mine) const override;
  std::vector<double> select(std::vector<double> mine, std::span<const std::uint64_t> places) const override;
  std::vector<meshing::FaceTally> all(std::vector<meshing::FaceTally> mine) const override;
  std::vector<std::array<std::uint32_t, 2>> all(
      std::vector<std::array<std::uint32_t, 2>> mine) const override;
  void refresh(std::vector<std::uint32_t>& of_triangles) const override;
  void refresh(std::vector<meshing::EdgeOnModel>& edges) const override;

 private:
  Peers& peers_;
  const LocalSurface& local_;
  const std::span<const std::uint32_t> own_;
};

}  // namespace weft::partition
