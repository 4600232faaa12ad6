// Two meshes between which fields are carried, whole or in parts.
#pragma once

#include <atomic>
#include <span>

#include "meshing/base/error.h"
#include "meshing/base/value_table.h"
#include "meshing/fields/interpolate.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_domain.h"

namespace weft::meshing {

/// Of a mesh in parts everybody has a part of the old mesh and one of the new, which need not be at the same
/// place: what a part of one needs of the other comes from there. All parts call the functions together.
class MeshPair {
 public:
  virtual ~MeshPair() = default;
  virtual const MetricDomain& old_mesh() const = 0;
  virtual const MetricDomain& new_mesh() const = 0;

  /// The tets of the old mesh about the part of the new one: all that it overlaps or that are near. May have
  /// none where that part has no points.
  virtual const MeshData& source() const = 0;
  /// Values at the vertices of the part of the old mesh, at those of the source.
  virtual ValueTable at_source(const ValueTable& at_old) const = 0;
  /// Whether tets at these distances from the points of the new mesh's part may be missing in the source; it
  /// is larger then. Infinity: the source has no tets.
  virtual bool widen(std::span<const double> distances) = 0;
  /// Nobody looks at the source any more, before it is asked for anew.
  virtual void release_source() {}

  /// Values at the vertices of the part of the new mesh, read at those of the part of the old one.
  virtual ValueTable read_back(const ValueTable& at_new) const = 0;
};

/// A fault of the new mesh; any other InputError is of the old one.
class NewMeshError : public InputError {
 public:
  explicit NewMeshError(const InputError& fault) : InputError(fault) {}
};

/// Returns call(), which looks at the new mesh alone.
template <class Call>
auto of_new_mesh(const Call& call) {
  try {
    return call();
  } catch (const InputError& fault) {
    throw NewMeshError(fault);
  }
}

/// Two whole meshes.
class WholePair final : public MeshPair {
 public:
  /// All must outlive the object. `interrupt`: the domains' (MetricDomain).
  WholePair(const MeshData& from, const MeshData& to, const std::atomic<bool>* interrupt = nullptr)
      : old_(from, interrupt), new_(to, interrupt) {}

  const MetricDomain& old_mesh() const override { return old_; }
  const MetricDomain& new_mesh() const override { return new_; }
  const MeshData& source() const override { return old_.mesh(); }
  ValueTable at_source(const ValueTable& at_old) const override { return at_old; }
  bool widen(std::span<const double>) override { return false; }
  ValueTable read_back(const ValueTable& at_new) const override {
    return interpolate(locator_in(new_.mesh()), at_new, old_.mesh().points).table;
  }

 private:
  WholeDomain old_, new_;
};

}  // namespace weft::meshing
