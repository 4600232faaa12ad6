// A cheap decomposition of meshes in which little is to be done: tets that follow each other in the input are
// kept together, and runs of them are divided, not tets.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/decompose/tet_measures.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// Whether tets that follow each other are neighbours: four of five have a vertex of the one before. As every
/// mesh that weft has written; not one whose tets come in any order. All ranks call together, each with its
/// share of the tets, in the order of the ranks.
bool follow_each_other(Peers& peers, std::span<const std::array<std::uint32_t, 4>> tets);

/// A tet that stands for its run.
struct RunSample {
  TetCorners corners;
  meshing::SymTensor cut_tensor;
};

/// Bisects runs of 32 tets, the first of which has a number that is a multiple of 32, by the place of the tet
/// in their middle. The rank that has this tet has the run; `sample(i)` is of tet i of this rank's. `work` is
/// of each, as Items::work. Parts have their share of the work to within a few runs; their interfaces are
/// more ragged than those of graph or bisection. All ranks call together; depends neither on their number nor
/// on who has what.
std::vector<SubdomainId> bisect_runs(Peers& peers, const Ranges& tets, std::span<const double> work,
                                     const std::function<RunSample(std::size_t)>& sample,
                                     std::uint32_t num_subdomains);

}  // namespace weft::partition
