// Which subdomain each tet belongs to: parts of equal work, found without any rank seeing all tets.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/metric/metric.h"
#include "partition/communication/peers.h"
#include "partition/decompose/partitioner.h"
#include "partition/decompose/tet_measures.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// This rank's tets, one entry each in every array.
struct Items {
  std::span<const meshing::Point> centres;
  std::span<const TetCorners> corners;
  std::span<const double> work;                            ///< any unit; negative and NaN count as 0
  std::span<const std::uint64_t> numbers;                  ///< in the whole input; settle ties
  std::span<const meshing::SymTensor> cut_tensors;         ///< cut_tensor of each
  std::span<const std::array<std::uint32_t, 4>> vertices;  ///< in the whole input
  std::span<const std::array<float, 4>> face_areas;        ///< in the metric; face i is opposite vertex i
  std::span<const double> complexities;                    ///< of the metric in each; all 0: not known
  /// How far each reaches along the partitioner's coordinate; empty where it has none.
  std::span<const double> coordinates = {};
};

/// Result of decompose().
struct Decomposition {
  std::vector<SubdomainId> subdomains;  ///< of each of this rank's tets: 0 to num_subdomains - 1
  std::string warning = {};             ///< where some were left empty on purpose; the same on all ranks
  std::vector<SubdomainId> seeds = {};  ///< of with_room_to_divide()
};

/// Divides the tets; all ranks call together. Depends on the tets of all ranks, not on which rank has which
/// nor on the number of ranks. Every tet counts for at least a tiny share of the greatest work, so that tets
/// without work are divided evenly too.
///
/// PQR and bisection: every cut leaves each side with its share of the work to within half a tet, so that
/// parts are balanced to one tet a cut; subdomains may be empty where tets are fewer or much work is in one
/// tet. Graph: to 3 % of a part; may leave a subdomain empty or in pieces. Where slabs would be thin there
/// are fewer (thin_slabs.h), and the other subdomains are empty, unless the partitioner wants them all.
///
/// Throws std::invalid_argument when num_subdomains is 0 or not the product of the partitioner's slabs, and
/// where the partitioner has a coordinate but the tets have none.
///
/// `items_are_read`: called before what takes most memory, if that does not read them; their memory may go.
Decomposition decompose(Peers& peers, const Items& items, std::uint32_t num_subdomains,
                        const Partitioner& partitioner, const std::function<void()>& items_are_read = {});

/// The parts of a decomposition spread over `num_subdomains`, no fewer than they are: behind each part come
/// as many subdomains without tets as its share of the work (an entry for each of this rank's tets) befits.
/// All ranks call together; depends on what decompose() depends on.
Decomposition with_room_to_divide(Peers& peers, Decomposition decomposition, std::span<const double> work,
                                  std::uint32_t parts, std::uint32_t num_subdomains);

/// Of `num` in proportion to `work`, for each at least one; num is no less than they are.
std::vector<std::uint32_t> apportion(std::span<const std::uint64_t> work, std::uint32_t num);

}  // namespace weft::partition
