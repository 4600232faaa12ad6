// What is classified on a model: a whole boundary, or one rank's part of one together with the triangles
// around it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/fixed_point_sum.h"
#include "meshing/geometry/model/geometry_model.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// A mesh edge on an edge of the model.
struct EdgeOnModel {
  std::array<std::uint32_t, 2> vertices;  ///< ascending
  std::uint32_t edge = kNoEntity;
  std::uint32_t unused = 0;   ///< no byte of a message is undefined
  std::array<double, 2> t{};  ///< parameters of the vertices
};

/// The one between these vertices, ascending, of edges that are sorted by vertices; or null.
inline const EdgeOnModel* find_edge(std::span<const EdgeOnModel> edges,
                                    const std::array<std::uint32_t, 2>& vertices) {
  const auto at = std::ranges::lower_bound(edges, vertices, {}, &EdgeOnModel::vertices);
  return at != edges.end() && at->vertices == vertices ? &*at : nullptr;
}

/// How far a vertex is from something. The nearest is less, of those the lowest.
struct NearVertex {
  double distance = std::numeric_limits<double>::infinity();
  std::uint64_t number = std::numeric_limits<std::uint64_t>::max();  ///< in the whole mesh
  friend auto operator<=>(const NearVertex&, const NearVertex&) = default;
};

/// Triangles of one reference on one face of the model, or on none.
struct FaceTally {
  std::uint32_t face;
  std::int32_t ref;
  std::uint64_t triangles = 0;
  std::array<std::uint64_t, 2> sides{};  ///< against the face's normal, along it
  double farthest = 0;                   ///< of those on no face: distance of a vertex from the model
  void add(const FaceTally& other);
};

/// Points and triangles are in the order of the whole boundary, so that what is found of a vertex or a
/// triangle has the same bits wherever it is found. All triangles at a vertex of an own triangle are here.
/// All parts call the functions from run() on together.
class BoundaryDomain {
 public:
  virtual ~BoundaryDomain() = default;

  /// Records of vertices (MeshData::association) are those of vertices of own triangles.
  virtual const MeshData& mesh() const = 0;
  /// Each triangle is one part's own.
  virtual bool owns(std::size_t triangle) const = 0;
  /// Of a vertex in the whole mesh, and back: kNoEntity for one that is not here.
  virtual std::uint32_t number(std::uint32_t vertex) const = 0;
  virtual std::uint32_t vertex(std::uint32_t number) const = 0;

  /// Runs what asks no other part. Where it throws in one, all throw.
  virtual void run(const std::function<void()>& action) const = 0;
  /// Over all parts, element by element.
  virtual std::vector<std::uint64_t> sum(std::vector<std::uint64_t> mine) const = 0;
  std::uint64_t sum(std::uint64_t mine) const { return sum(std::vector{mine})[0]; }
  virtual std::vector<FixedPointSum> sum(std::vector<FixedPointSum> mine) const = 0;
  virtual std::vector<NearVertex> nearest(std::vector<NearVertex> mine) const = 0;
  virtual double max(double mine) const = 0;
  virtual Box unite(const Box& mine) const = 0;
  /// The values at these places of all parts' values in ascending order.
  virtual std::vector<double> select(std::vector<double> mine,
                                     std::span<const std::uint64_t> places) const = 0;
  /// What all parts give, in any order.
  virtual std::vector<FaceTally> all(std::vector<FaceTally> mine) const = 0;
  virtual std::vector<std::array<std::uint32_t, 2>> all(
      std::vector<std::array<std::uint32_t, 2>> mine) const = 0;
  /// Values of triangles that are not own ones become those of their owners.
  virtual void refresh(std::vector<std::uint32_t>& of_triangles) const = 0;
  /// Those at own triangles, which each part gives, become all between vertices here, sorted by vertices.
  virtual void refresh(std::vector<EdgeOnModel>& edges) const = 0;
};

/// A boundary that nobody else has a part of.
class WholeBoundaryDomain final : public BoundaryDomain {
 public:
  /// `mesh` must outlive the object.
  explicit WholeBoundaryDomain(const MeshData& mesh) : mesh_(mesh) {}

  const MeshData& mesh() const override { return mesh_; }
  bool owns(std::size_t) const override { return true; }
  std::uint32_t number(std::uint32_t vertex) const override { return vertex; }
  std::uint32_t vertex(std::uint32_t number) const override { return number; }
  void run(const std::function<void()>& action) const override { action(); }
  std::vector<std::uint64_t> sum(std::vector<std::uint64_t> mine) const override { return mine; }
  std::vector<FixedPointSum> sum(std::vector<FixedPointSum> mine) const override { return mine; }
  std::vector<NearVertex> nearest(std::vector<NearVertex> mine) const override { return mine; }
  double max(double mine) const override { return mine; }
  Box unite(const Box& mine) const override { return mine; }
  std::vector<double> select(std::vector<double> mine, std::span<const std::uint64_t> places) const override;
  std::vector<FaceTally> all(std::vector<FaceTally> mine) const override { return mine; }
  std::vector<std::array<std::uint32_t, 2>> all(
      std::vector<std::array<std::uint32_t, 2>> mine) const override {
    return mine;
  }
  void refresh(std::vector<std::uint32_t>&) const override {}
  void refresh(std::vector<EdgeOnModel>&) const override {}

 private:
  const MeshData& mesh_;
};

}  // namespace weft::meshing
