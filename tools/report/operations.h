// What the workers of a run spend their time on, as the report calls it: the paper's operations, and those
// that it does not have.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/trace/summary.h"
#include "graph/dataflow/dump/graph_dump.h"

namespace weft::report {

/// In the order in which they are stacked.
inline constexpr std::array<std::string_view, 11> kOperations = {"interior adaptation",
                                                                 "MII adaptation",
                                                                 "interface refinement",
                                                                 "colouring and quality check",
                                                                 "gather",
                                                                 "scatter",
                                                                 "topology update",
                                                                 "conversion",
                                                                 "misc",
                                                                 "help",
                                                                 "idle"};
using OperationIndex = std::size_t;
inline constexpr OperationIndex kInteriorAdaptation = 0, kShiftedAdaptation = 1, kInterfaceRefinement = 2;
inline constexpr OperationIndex kChecks = 3;
inline constexpr OperationIndex kConversion = 7, kMisc = 8, kHelp = 9, kIdle = 10;

/// Seconds of workers by operation.
using OperationSeconds = std::array<double, kOperations.size()>;

/// What a node of the subdomains' graph does; misc for a name that is not known.
OperationIndex operation_of_node(std::string_view name);

/// What nodes that adapt do beside it: a counter of their seconds, and the operation that it is.
struct Beside {
  std::string_view counter;
  OperationIndex operation;
};
inline constexpr std::array<Beside, 2> kBeside = {
    {{"interface refinement, seconds", kInterfaceRefinement}, {"quality check, seconds", kChecks}}};
using BesideSeconds = std::array<double, kBeside.size()>;

/// Adds a node's `took` seconds to what it does; of them `beside`, as far as there are so many, to what it
/// does beside.
void add_seconds(std::string_view node, double took, const BesideSeconds& beside, OperationSeconds& seconds);

/// The seconds of a run that went into something beside.
BesideSeconds beside_seconds(const graph::dataflow::GraphDump& graph, const graph::dataflow::DumpedRun& run);

/// Adds what a rank's workers did while they were in no node: conversion, help and idle, and misc. Nodes of
/// simulated ranks take processor time: what their workers waited for cores that ranks share, which only
/// these count, is idle, not misc.
void add_beside_nodes(const engine::RankSummary& summary, double in_nodes, OperationSeconds& seconds);

/// The seconds of one rank's workers: they add up to workers * wall, but for the rounding. Nodes from the
/// graph, conversion, help and idle from the engine, misc what handlers did beside nodes. Without runs all
/// that handlers did is misc.
OperationSeconds seconds_of_rank(const engine::RankSummary& summary, const graph::dataflow::GraphDump& graph);

}  // namespace weft::report
