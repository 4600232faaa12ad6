// From a surface to a written mesh: what `weft mesh SURFACE` and the bodies have in common.
#pragma once

#include <string>
#include <vector>

#include "meshing/initial/fill_volume.h"
#include "meshing/io/files/mesh_contents.h"
#include "tools/weft/options/verbosity.h"

namespace CLI {
class App;
}

namespace weft::tools {

struct VolumeRequest {
  std::string output;
  std::string background, metric;  ///< files of sizes to use instead of the surface's
  meshing::SurfaceChecks checks;
  meshing::GridOptions grid;
  meshing::FillOptions fill;
  Verbosity verbosity;
};

/// Declares --out, --threads, --progress and --quiet.
void add_volume_output(CLI::App& command, VolumeRequest& request);

/// Makes the mesh of `surface` (called `name` in messages), writes it and prints a summary; returns the exit
/// code.
int make_volume(const std::string& name, const meshing::MeshData& surface, const meshing::RefNames& names,
                const VolumeRequest& request);

}  // namespace weft::tools
