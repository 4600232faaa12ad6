// Progress of a run: reports of the subdomains, and rank 0's estimates. The run does not depend on them.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "engine/trace/trace.h"
#include "meshing/kernel/nonconforming.h"
#include "partition/subdomain/global_id.h"

namespace weft::graph::adaptation {

/// Report of one subdomain. Plain data.
struct SubdomainProgress {
  partition::SubdomainId subdomain;
  std::uint32_t number = 0;   ///< of this report: the highest is the latest, whichever rank it comes from
  std::uint32_t step = 0;     ///< 0: adapts its interior; r + 1: in round r of the shifts
  bool rests = false;         ///< nothing left to do, unless a neighbour wakes it
  float done = 0;             ///< share of the step, 0 to 1
  double predicted_tets = 0;  ///< of the adapted subdomain: its weight
  meshing::Nonconforming left = {};  ///< after its last adaptation; no tets: it has not been adapted yet
};

/// Latest reports of the subdomains of one rank; thread-safe.
class ProgressBoard {
 public:
  void post(const SubdomainProgress& news);
  /// The latest of each subdomain that has posted since the last call.
  std::vector<SubdomainProgress> take();

 private:
  std::mutex mutex_;
  std::unordered_map<partition::SubdomainId, SubdomainProgress> latest_;
};

/// State of a run at some time.
struct RunProgress {
  std::uint32_t subdomains = 0, most_shifts = 0;
  std::uint32_t step = 0;  ///< of the slowest subdomain that does not rest: as SubdomainProgress::step
  std::uint32_t done = 0;  ///< subdomains that are through this step, those at rest included
  std::uint32_t at_rest = 0;
  double share = 0;             ///< of this step's work that is done, by predicted tets
  std::uint32_t adapted = 0;    ///< subdomains that `left` is known of
  meshing::Nonconforming left;  ///< edges of an interface count in each subdomain that has them
  double seconds = 0;           ///< since the run began
  /// Until this step is done, at the pace of its work so far (for a shift that has just begun: going by those
  /// before). Empty: not known yet.
  std::optional<double> step_left;
  /// Until all is done, if shifts go on getting shorter as they have, or as they use to where too few have
  /// been seen. Empty before the first shift is under way: how much it will have to do is not known.
  std::optional<double> all_left;
  /// A bound of that: if all shifts that are allowed were needed, and got shorter as slowly as any so far
  /// have, or not at all where too few have been seen. Empty where all_left is.
  std::optional<double> most_left;
};

/// Rank 0's view of all subdomains.
class ProgressTable {
 public:
  ProgressTable(std::uint32_t subdomains, std::uint32_t most_shifts, engine::TimePoint begin);

  void hear(const std::vector<SubdomainProgress>& news);
  /// To be called now and then, with ascending times: how long steps take is seen only then.
  RunProgress at(engine::TimePoint time);

 private:
  std::uint32_t slowest_step() const;
  double share_of(std::uint32_t step) const;
  double usual_ratio() const;
  double slowest_ratio() const;
  void estimate(RunProgress& progress) const;

  std::uint32_t subdomains_, most_shifts_;
  engine::TimePoint begin_;
  std::unordered_map<partition::SubdomainId, SubdomainProgress> known_;
  std::uint32_t step_ = 0;
  double step_began_ = 0;       ///< seconds since the run began
  double share_at_begin_ = 0;   ///< of the step: some subdomains are ahead
  std::vector<double> shifts_;  ///< seconds that the complete shifts took
};

}  // namespace weft::graph::adaptation
