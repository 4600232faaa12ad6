// What a metric is made on: a whole mesh, or one rank's part of a mesh together with the vertices around it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric_field.h"

namespace weft::meshing {

/// Points and tets are in the order of the whole mesh, so that what is computed of a vertex's tets or
/// neighbours has the same bits wherever it is computed. Of vertices that are not owned somebody else makes
/// the values; they are taken from there by refresh(). All parts call the functions that are not const of
/// values together.
class MetricDomain {
 public:
  /// `interrupt`: once set, long work ends early with what it has; null: never. Parts may have flags of their
  /// own.
  explicit MetricDomain(const std::atomic<bool>* interrupt = nullptr) : interrupt_(interrupt) {}
  virtual ~MetricDomain() = default;

  /// Points and tets; of a part those that the values of owned vertices depend on.
  virtual const MeshData& mesh() const = 0;
  virtual bool owns(std::size_t vertex) const = 0;
  /// Of the whole mesh.
  virtual std::size_t num_points() const = 0;
  /// largest_size() of the whole mesh.
  virtual double largest_size() const = 0;

  /// Over all parts.
  virtual double max(double mine) const = 0;
  virtual bool any(bool mine) const = 0;
  /// at(v) >= 0, summed over the vertices that are owned, of all parts.
  virtual double sum(const std::function<double(std::size_t)>& at) const = 0;
  /// The same of any sign.
  virtual double signed_sum(const std::function<double(std::size_t)>& at) const = 0;
  /// Of the whole mesh.
  virtual double complexity(const LogMetricField& field) const = 0;

  /// Values at vertices that are not owned become those of their owners.
  virtual void refresh(std::vector<SymTensor>& values) const = 0;
  virtual void refresh(std::vector<std::uint8_t>& values) const = 0;
  /// `columns` numbers a vertex, side by side.
  virtual void refresh(std::size_t columns, std::vector<double>& values) const = 0;
  /// The same where only these owned vertices have new values: returns the vertices that have new ones by
  /// this.
  virtual std::vector<std::uint32_t> refresh_changed(std::span<const std::uint32_t> changed,
                                                     std::vector<SymTensor>& values) const = 0;

  /// Whether this part's flag is set.
  bool interrupted_here() const { return interrupt_ && interrupt_->load(std::memory_order_relaxed); }
  /// That of any part.
  bool interrupted() const { return any(interrupted_here()); }

 private:
  const std::atomic<bool>* interrupt_;
};

/// A mesh that nobody else has a part of.
class WholeDomain final : public MetricDomain {
 public:
  /// `mesh` must outlive the object.
  explicit WholeDomain(const MeshData& mesh, const std::atomic<bool>* interrupt = nullptr)
      : MetricDomain(interrupt), mesh_(mesh) {}

  const MeshData& mesh() const override { return mesh_; }
  bool owns(std::size_t) const override { return true; }
  std::size_t num_points() const override { return mesh_.points.size(); }
  double largest_size() const override { return meshing::largest_size(mesh_); }
  double max(double mine) const override { return mine; }
  bool any(bool mine) const override { return mine; }
  double sum(const std::function<double(std::size_t)>& at) const override;
  double signed_sum(const std::function<double(std::size_t)>& at) const override { return sum(at); }
  double complexity(const LogMetricField& field) const override;
  void refresh(std::vector<SymTensor>&) const override {}
  void refresh(std::vector<std::uint8_t>&) const override {}
  void refresh(std::size_t, std::vector<double>&) const override {}
  std::vector<std::uint32_t> refresh_changed(std::span<const std::uint32_t>,
                                             std::vector<SymTensor>&) const override {
    return {};
  }

 private:
  const MeshData& mesh_;
};

/// A quarter of the volumes of every vertex's tets.
std::vector<double> vertex_volumes(const MeshData& mesh);

/// M <- (target/C)^(2/3) M, so that the complexity becomes `target`.
void scale_to_complexity(const MetricDomain& domain, double target, LogMetricField& field);
/// The same with sizes limited to [hmin, hmax] (metric_field.h).
double scale_to_complexity(const MetricDomain& domain, double target, double hmin, double hmax,
                           LogMetricField& field);

}  // namespace weft::meshing
