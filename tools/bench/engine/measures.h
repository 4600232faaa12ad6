// What the engine's benchmarks measure with: clocks, work of a known length, statistics, numbers of all
// ranks.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "engine/network/transport.h"

namespace weft::bench {

/// Seconds on the monotonic clock, which the processes of a node share.
double wall_clock();
/// CPU seconds of the calling thread, and of the process.
double thread_cpu();
double process_cpu();

/// Value below which `share` of the values lie. There must be some.
double quantile(std::vector<double> values, double share);
inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

/// Computes for so many steps: a given amount of work, however the machine is loaded.
void work(std::uint64_t steps);
/// How many steps a thread takes in a second of CPU time.
double steps_per_second();
/// Computes until the thread has used so many seconds of CPU.
void work_for(double seconds);

/// CPU seconds that the machine has spent on anything since it started; differences tell about other
/// programs.
double machine_cpu();

/// Each rank's numbers, at rank 0; elsewhere empty. All ranks must call it.
std::vector<std::vector<double>> gather(engine::Transport& transport, std::vector<double> mine);

}  // namespace weft::bench
