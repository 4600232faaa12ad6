// From every rank's share of the input to the subdomains that start on it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "meshing/base/box.h"
#include "partition/communication/peers.h"
#include "partition/decompose/partitioner.h"
#include "partition/distribute/tet_records.h"
#include "partition/slice/mesh_slice.h"
#include "partition/subdomain/geometry.h"
#include "partition/subdomain/subdomain_start.h"

namespace weft::partition {

/// What is known of the whole mesh before it is decomposed.
struct InputMeasures {
  std::uint64_t tets = 0;
  double complexity = 0;     ///< in its metric
  double mean_quality = 0;   ///< of the tets, in its metric, weighed by what each has of the complexity
  double largest_share = 0;  ///< of the complexity, in one tet
};

struct DecompositionOptions {
  std::uint32_t num_subdomains = 1;
  Partitioner partitioner;
  double ridge_angle_degrees = meshing::kRidgeAngle;  ///< of meshing::Surface
  double target_complexity = 0;  ///< the metric is scaled to it (paper, equation 3); 0: as it is
  bool equal_tets = false;       ///< parts of equally many tets of the input, not of equal predicted work
  std::shared_ptr<const meshing::Model> model = nullptr;  ///< of the boundary; on every rank or none
  /// How many of the subdomains have tets at first, 1 to num_subdomains: these divide later. The same on all
  /// ranks. Null: all.
  std::function<std::uint32_t(const InputMeasures&)> parts_at_first = {};
  /// What the partitioner's coordinate is at this rank's slice of points (partition/coordinate); empty where
  /// it has none.
  std::vector<double> coordinate = {};
};

/// What one rank has after the decomposition.
struct Distributed {
  std::shared_ptr<const Geometry> geometry;  ///< of the whole mesh
  std::vector<SubdomainStart> starts;        ///< of the subdomains whose home_rank this is, by id
  std::vector<std::string> warnings;         ///< what was repaired; the same on every rank
  meshing::Box box;                          ///< of the whole mesh
  double complexity = 0;                     ///< of the whole mesh in its metric
  double mean_quality = 0;                   ///< InputMeasures::mean_quality
  bool cut_by_runs = false;                  ///< as Partitioner::runs_suffice allows
  /// Where some subdomains have no tets at first: those that have, ascending, from 0. Each is to be divided
  /// with the ones up to the next (partition/divide), which are as many as befits its work.
  std::vector<SubdomainId> seeds;
};

/// Checks, completes, decomposes and distributes the mesh; all ranks call together. Subdomains, geometry,
/// warnings, box and complexity do not depend on the number of ranks nor on the shares. The geometry, kinds,
/// flags and hints are those that meshing::import_mesh finds in the whole mesh.
/// The work of a tet is the number of tets that is expected of it: 12 times its complexity, and a tenth for
/// handling it.
///
/// Throws on every rank alike: meshing::InputError (no file name) in the words of meshing::import_mesh where
/// it would; std::invalid_argument where the shares do not make up the mesh, or the number of subdomains is
/// 0, above 2^23 - 2 or not the partitioner's. A rank holds its share of points and tets, its subdomains,
/// and a share of the boundary, with up to 350 bytes a tet of temporaries.
Distributed distribute(Peers& peers, MeshSlice&& slice, const DecompositionOptions& options);

}  // namespace weft::partition
