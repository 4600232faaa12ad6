// The initial data of one subdomain: a part of the input mesh as plain arrays, and its connections to the
// other parts.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_piece.h"
#include "meshing/metric/metric.h"
#include "partition/subdomain/background_store.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// Arrays of one entry a vertex or a tet; indices are local.
struct SubdomainStart {
  SubdomainId subdomain;

  std::vector<meshing::Point> points;
  std::vector<std::int32_t> point_refs;
  std::vector<meshing::LogMetric> log_metrics;  ///< of the target: scaled, limited and graded already
  std::vector<GlobalId> ids;               ///< (lowest subdomain that holds the vertex, number in the input)
  std::vector<meshing::VertexKind> kinds;  ///< by the whole surface
  std::vector<std::uint8_t> flags;         ///< meshing::VertexFlag
  std::vector<std::uint32_t> surface_hints;  ///< meshing::Surface::vertex_hint
  /// The pieces of the surface near boundary faces; see partition/subdomain/surface_cover.h.
  std::vector<meshing::SurfacePieces::Piece> surface;

  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::int32_t> tet_refs;

  /// A tet's face on the boundary or on a material interface; of one between two tets of this subdomain both
  /// are listed.
  struct BoundaryFace {
    std::uint32_t tet;
    std::uint32_t face;
    meshing::PatchId patch;
  };
  std::vector<BoundaryFace> boundary_faces;

  /// Both ends in this subdomain, and so is at least one tet that has the edge.
  struct FeatureEdge {
    std::array<std::uint32_t, 2> ends;
    meshing::CurveId curve;
  };
  std::vector<FeatureEdge> feature_edges;

  /// One line for each vertex that other subdomains hold too and each of those subdomains, sorted.
  struct Shared {
    std::uint32_t vertex;
    SubdomainId other;
    friend auto operator<=>(const Shared&, const Shared&) = default;
  };
  std::vector<Shared> shared;

  /// Where the background is another mesh: the pieces of it that the tets cover or their vertices are in, and
  /// the place of each vertex there. Else empty: the background is made of the tets.
  std::vector<std::shared_ptr<const BackgroundPiece>> background;
  std::vector<BackgroundTet> background_places;
};

}  // namespace weft::partition
