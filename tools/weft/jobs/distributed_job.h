// One adaptation in subdomains, on one rank or many, from files to files.
#pragma once

#include <string>

#include "tools/weft/jobs/adapt_job.h"

namespace weft::tools {

/// What `weft adapt` is told beside an AdaptRequest when it works in subdomains.
struct SubdomainRequest {
  std::uint32_t subdomains = 0;  ///< 0: not asked for; then the partitioner's slabs or a few for each thread
  std::string partitioner;       ///< empty: not asked for; then graph
  bool equal_tets = false;
  int layers = 2;
  bool by_faces = false;
  std::string shifts = "auto";  ///< or the largest number of them
  bool refine_interface = true;
  bool freeze_tets = false;
  std::string balancer = "stealing";
  bool check = false;  ///< graph::adaptation::DistributedOptions::check
};

/// Whether this run works in subdomains: it was asked to, or to partition, or is under mpirun.
bool in_subdomains(const SubdomainRequest& request);

/// Runs the adaptation on all ranks, writes the result, and prints errors and (unless `quiet`) the summary on
/// rank 0. Returns the exit code, the same on all ranks. Throws CLI::ParseError for a request that makes no
/// sense.
int run_in_subdomains(const AdaptRequest& request, const SubdomainRequest& subdomains, bool quiet);

}  // namespace weft::tools
