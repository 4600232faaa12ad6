// The division of a subdomain into several, for subdomains that have had no tets yet: its mesh is decomposed
// like an input, and handed over as in a shift. What follows is a shift's too: the new ones take their part
// by scatter(), old neighbours that divide at the same time tell each other where tets have gone, and notices
// name all holders of what several had held.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "meshing/geometry/surface/surface.h"
#include "partition/decompose/partitioner.h"
#include "partition/shift/shift.h"

namespace weft::partition {

/// How a subdomain is divided.
struct DivisionOptions {
  std::uint32_t num_parts = 1;  ///< for the subdomain itself and those with the next numbers
  Partitioner partitioner;      ///< of slabs: num_parts of them
  bool equal_tets = false;      ///< not: of equal work in the metric
  bool keeps_all = false;       ///< the others get nothing
};

struct PartParcel {
  SubdomainId to;
  Parcel parcel;
};
struct Divided {
  std::vector<PartParcel> parcels;
  std::string warning;  ///< Decomposition::warning
};

/// A parcel for each neighbour of the interface (without tets) and each new part but the subdomain's own, by
/// addressee. scatter() must follow, with the parcels of all neighbours, which divide as well. `surface`: of
/// the mesh's patches; a partitioner with a coordinate needs it, and that the subdomain is the whole mesh.
Divided divide(Subdomain& subdomain, const DivisionOptions& options,
               const meshing::Surface* surface = nullptr);

/// What a subdomain is predicted to have in the end, as in TetMeasures::work().
double predicted_tets(const Subdomain& subdomain);

}  // namespace weft::partition
