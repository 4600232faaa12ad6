// From a surface to a written mesh: what `weft mesh SURFACE` and the bodies have in common.
#pragma once

#include <string>
#include <vector>

#include "tools/weft/options/verbosity.h"
#include "weft/weft.h"

namespace CLI {
class App;
}

namespace weft::tools {

struct VolumeRequest {
  std::string surface;  ///< the file that is filled; empty: a body
  std::string output;
  std::string background, metric;  ///< files of sizes to use instead of the surface's
  FillOptions fill;
  Verbosity verbosity;
};

/// Declares --out, --threads, --progress and --quiet.
void add_volume_output(CLI::App& command, VolumeRequest& request);

/// Makes the mesh of `surface` (called `name` in messages), writes it and prints a summary; returns the exit
/// code.
int make_volume(const std::string& name, const Mesh& surface, const RefNames& names,
                const VolumeRequest& request);

}  // namespace weft::tools
