// What the faces of a picture are coloured by, and the values that say so.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "meshing/io/files/mesh_contents.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/metric.h"
#include "tools/picture/colour.h"
#include "tools/picture/facet.h"
#include "tools/picture/legend.h"
#include "tools/picture/shown_faces.h"

namespace weft::picture {

enum class ColourBy {
  none,           ///< one colour for the surface, one for what a cut lays bare
  ref,            ///< references of triangles
  subdomain,      ///< references of tets
  quality,        ///< mean ratio of the tets
  length,         ///< of the edges, in the metric
  nonconforming,  ///< tets with an edge outside [1/sqrt 2, sqrt 2] in the metric
  field,          ///< values at the vertices
};

/// What the colours are taken from. All of it must outlive whoever uses it.
struct ColourSource {
  ColourBy by = ColourBy::none;
  const meshing::MeshData& mesh;
  std::span<const meshing::LogMetric> log_metrics;  ///< one a vertex; none needed but for lengths
  std::span<const double> field;                    ///< one a vertex, for ColourBy::field
  std::string field_name;
};

/// Turns what is shown into facets with values. Without a metric the quality is that of the shape. Faces
/// without a tet, of meshes that have none, are measured by their own edges; their quality is missing.
class Colouring {
 public:
  explicit Colouring(const ColourSource& source);

  Facet facet(const ShownFace& face) const;
  /// Appends a triangle or two. Lengths: that of the tet's edge that is farthest from 1.
  void append(const Section& section, std::vector<Facet>& facets) const;

  /// The scale for these facets, with a legend that names what is on it; `range` replaces the ends of a
  /// continuous one.
  Legend legend(std::span<const Facet> facets, const meshing::RefNames& names, const Theme& theme,
                const std::optional<std::pair<double, double>>& range) const;

 private:
  double tet_value(std::uint32_t tet) const;
  double edge_length(std::uint32_t a, std::uint32_t b) const;
  double off_length(std::span<const std::uint32_t> vertices) const;
  double category(std::int32_t ref) const;
  std::vector<Colour> category_colours(const Theme& theme) const;
  Legend category_legend(std::span<const Facet> facets, const meshing::RefNames& names,
                         const Theme& theme) const;
  Legend continuous_legend(std::span<const Facet> facets, const Theme& theme) const;

  ColourSource source_;
  std::vector<std::int32_t>
      refs_;  ///< ascending; category i is refs_[i], the one after the last is the inside
};

}  // namespace weft::picture
