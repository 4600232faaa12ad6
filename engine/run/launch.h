// The frame of a program that uses the engine.
#pragma once

#include <functional>

#include "engine/network/transport.h"

namespace weft::engine {

/// Exit status of a run that failed.
inline constexpr int kExitFailed = 2;

/// Connects the ranks (those of mpirun if it started this program, else this process alone), calls `body`,
/// and disconnects. Returns what `body` returns; kExitFailed when the run failed on any rank, and then one
/// rank has written why to stderr. A rank that leaves `body` with another exception takes the others down.
int launch(int argc, char** argv, const std::function<int(Transport&)>& body);

}  // namespace weft::engine
