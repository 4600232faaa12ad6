// What the report's 3-D view shows of a mesh: its surface and sections by planes, thinned out to a few
// megabytes.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/geometry/model/model.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"
#include "tools/report/thinning.h"

namespace weft::report {

inline constexpr float kNoDeviation = -1;

/// A triangle with what it may be coloured by.
struct ViewFacet {
  std::array<Corner, 3> corners;
  std::uint32_t subdomain = 0;
  float quality = 0;  ///< mean ratio of its tet
  float length = 1;   ///< of its tet's edges in the metric, that which is farthest from 1 by ratio
  float deviation = kNoDeviation;  ///< of its centroid from the CAD model; only on the surface
};

/// The surface, or the section by one plane.
struct ViewLayer {
  int axis = -1;        ///< of the plane: 0 to 2; -1: the surface
  double position = 0;  ///< of the plane
  std::vector<ViewFacet> facets;
  bool thinned = false;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(axis, position, facets, thinned);
  }
};

struct MeshView {
  std::vector<ViewLayer> layers;  ///< the surface, then sections by axis and position

  template <class Archive>
  void serialize(Archive& archive) {
    archive(layers);
  }
};

struct MeshViewOptions {
  int sections = 7;                     ///< planes across each axis, at equal distances
  std::size_t surface_facets = 60'000;  ///< at most
  std::size_t section_facets = 4'000;   ///< of each section, at most
};

/// A mesh or a piece of one, whose listed triangles are what its surface shows. Refers to what it is given.
struct ViewedPiece {
  const meshing::MeshData& mesh;
  std::span<const meshing::LogMetric> log_metrics;  ///< one a vertex
  std::uint32_t subdomain = 0;
};

/// Surface and sections of all pieces together, thinned out. `box`: of the whole mesh; `model`: that the
/// pieces' records are of, or null. Throws InputError (no file name) for triangles and tets with indices out
/// of range. Multithreaded on TBB (in the caller's arena); the result does not depend on the number of
/// threads. Values are worked out of those tets alone that something in the view stands for.
MeshView mesh_view(std::span<const ViewedPiece> pieces, const meshing::Box& box,
                   const MeshViewOptions& options, const meshing::Model* model = nullptr);

/// Adds the facets of another part of the mesh, made with the same box and options.
void append(MeshView& view, MeshView&& part);

/// Joins vertices on grids, coarser and coarser, until no layer has more facets than the options allow; what
/// remains of several facets has their worst quality, length and deviation. Multithreaded as mesh_view().
void thin_out(MeshView& view, const meshing::Box& box, const MeshViewOptions& options);

/// As in the schema "weft-profile-1", "mesh": positions in 16 bits an axis, other values in 8 or 16.
nlohmann::ordered_json json_of(const MeshView& view, const meshing::Box& box);

}  // namespace weft::report
