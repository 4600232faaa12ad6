// Progress of a run: reports of the subdomains, their sums, and rank 0's estimates. The run does not depend
// on them.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "engine/trace/trace.h"
#include "meshing/kernel/nonconforming.h"

namespace weft::graph::adaptation {

/// Report of one subdomain. Plain data.
struct SubdomainProgress {
  std::uint32_t step = 0;            ///< 0: adapts its interior; r + 1: in round r of the shifts
  bool rests = false;                ///< nothing left to do, unless a neighbour wakes it
  float done = 0;                    ///< share of the step, 0 to 1
  double predicted_tets = 0;         ///< of the adapted subdomain: its weight
  meshing::Nonconforming left = {};  ///< after its last adaptation; no tets: it has not been adapted yet
};

/// Sums of the latest reports of subdomains, as large however many they are. Each report goes to the rank
/// where the subdomain is then, and takes the one before it away there, too, where that was told elsewhere:
/// so what one rank has may be less than nothing, and the sum over all ranks is right.
struct ProgressSums {
  /// Of those that are in a step.
  struct Step {
    std::int64_t subdomains = 0, done = 0, at_rest = 0;  ///< all; through it or at rest; at rest
    double tets = 0, tets_done = 0, tets_at_rest = 0;    ///< the same by predicted tets, parts of it too

    Step& operator+=(const Step& other);
    friend bool operator==(const Step&, const Step&) = default;
  };
  std::vector<Step> steps;      ///< by number
  meshing::Nonconforming left;  ///< modulo 2^64

  /// `before`: the report of this subdomain that `now` takes the place of, wherever that was told; none: it
  /// is the first.
  void replace(const std::optional<SubdomainProgress>& before, const SubdomainProgress& now);
  ProgressSums& operator+=(const ProgressSums& other);

  template <class Archive>
  void serialize(Archive& archive) {
    archive(steps, left);
  }
};

/// What the subdomains have told on one rank; thread-safe.
class ProgressBoard {
 public:
  /// As ProgressSums::replace().
  void post(const std::optional<SubdomainProgress>& before, const SubdomainProgress& now);
  /// Of all that has been told here, if there is anything new since the last call.
  std::optional<ProgressSums> take();

 private:
  std::mutex mutex_;
  ProgressSums sums_;
  bool is_new_ = false;
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

/// What rank 0 makes of the sums. Of a subdomain that has just moved it may hear the latest report before
/// what was told on the rank where it was: for that while it counts as less far than it is.
class ProgressEstimator {
 public:
  ProgressEstimator(std::uint32_t subdomains, std::uint32_t most_shifts, engine::TimePoint begin);

  /// Of all ranks, in place of what was heard before.
  void hear(ProgressSums sums) { sums_ = std::move(sums); }
  /// To be called now and then, with ascending times: how long steps take is seen only then.
  RunProgress at(engine::TimePoint time);

 private:
  ProgressSums::Step through(std::uint32_t step) const;
  std::uint32_t slowest_step() const;
  double share_of(std::uint32_t step) const;
  double usual_ratio() const;
  double slowest_ratio() const;
  void estimate(RunProgress& progress) const;

  std::uint32_t subdomains_, most_shifts_;
  engine::TimePoint begin_;
  ProgressSums sums_;
  std::uint32_t step_ = 0;
  double step_began_ = 0;       ///< seconds since the run began
  double share_at_begin_ = 0;   ///< of the step: some subdomains are ahead
  std::vector<double> shifts_;  ///< seconds that the complete shifts took
};

}  // namespace weft::graph::adaptation
