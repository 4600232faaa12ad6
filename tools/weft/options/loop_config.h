// The configuration of `weft loop`: read from JSON, checked key by key.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "weft/weft.h"

namespace weft::tools {

struct LoopConfig {
  std::string file;                  ///< as the user named it
  std::filesystem::path mesh;        ///< the one to start with
  std::string solver;                ///< a line for the shell, with {mesh}, {solution}, {restart}, {cycle}
  std::filesystem::path home;        ///< the configuration's folder, where the solver runs
  std::filesystem::path folder;      ///< of the results
  std::vector<double> complexities;  ///< one a cycle after the first solution
  std::string mesh_extension = ".meshb", solution_extension = ".solb";
  Options options;       ///< what all cycles share
  std::string launcher;  ///< what `weft adapt` is started by, such as mpirun -n 8; empty: done here

  /// What cycle `cycle` depends on, as far as the configuration says it: a finished cycle is kept only as
  /// long as this stays the same. Threads, limits and folders are not among it.
  nlohmann::ordered_json settings(std::size_t cycle) const;
};

/// Throws InputError naming file, key and reason: JSON that cannot be parsed, missing, unknown, wrong or
/// contradicting keys.
LoopConfig read_loop_config(const std::string& file);

}  // namespace weft::tools
