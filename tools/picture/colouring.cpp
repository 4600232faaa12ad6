// Values of faces and sections, and the scales that fit them.
#include "tools/picture/colouring.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "meshing/metric/measures.h"

namespace weft::picture {
namespace {

using meshing::kNoNeighbour;
using meshing::LogMetric;
using meshing::Point;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kLongestUnit = std::numbers::sqrt2, kShortestUnit = 1 / std::numbers::sqrt2;

bool is_discrete(ColourBy by) {
  return by == ColourBy::none || by == ColourBy::ref || by == ColourBy::subdomain ||
         by == ColourBy::nonconforming;
}

std::vector<std::int32_t> distinct(std::vector<std::int32_t> refs) {
  std::ranges::sort(refs);
  refs.erase(std::ranges::unique(refs).begin(), refs.end());
  return refs;
}

Point corner_of(const meshing::MeshData& mesh, const Section::Corner& corner) {
  const Point& from = mesh.points[corner.from];
  return from + corner.share * (mesh.points[corner.to] - from);
}

std::string name_of(const meshing::RefNames& names, int dimension, std::int32_t ref) {
  return names.all().contains({dimension, ref}) ? names.name(dimension, ref) : std::to_string(ref);
}

/// The least and the largest value of the facets; both 0 where none has a value.
std::pair<double, double> extent(std::span<const Facet> facets) {
  double lo = HUGE_VAL, hi = -HUGE_VAL;
  for (const Facet& facet : facets)
    for (std::size_t i = 0; i < (facet.blend == Blend::constant ? 1u : 3u); ++i)
      if (!std::isnan(facet.values[i])) {
        lo = std::min(lo, facet.values[i]);
        hi = std::max(hi, facet.values[i]);
      }
  return lo <= hi ? std::pair{lo, hi} : std::pair{0.0, 0.0};
}

}  // namespace

Colouring::Colouring(const ColourSource& source) : source_(source) {
  if (source.by == ColourBy::ref) refs_ = distinct(source.mesh.triangle_refs);
  if (source.by == ColourBy::subdomain) refs_ = distinct(source.mesh.tet_refs);
}

double Colouring::category(std::int32_t ref) const {
  return static_cast<double>(std::ranges::lower_bound(refs_, ref) - refs_.begin());
}

double Colouring::edge_length(std::uint32_t a, std::uint32_t b) const {
  const auto& p = source_.mesh.points;
  return meshing::edge_length(p[b] - p[a], meshing::exp_fast(source_.log_metrics[a]),
                              meshing::exp_fast(source_.log_metrics[b]));
}

/// Of the edges between these vertices, the length that is farthest from 1, by ratio.
double Colouring::off_length(std::span<const std::uint32_t> vertices) const {
  double off = 1;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (std::size_t j = i + 1; j < vertices.size(); ++j) {
      const double length = edge_length(vertices[i], vertices[j]);
      if (std::abs(std::log(length)) > std::abs(std::log(off))) off = length;
    }
  return off;
}

double Colouring::tet_value(std::uint32_t tet) const {
  const auto& vertices = source_.mesh.tets[tet];
  std::array<Point, 4> points;
  std::array<LogMetric, 4> log_metrics = {};  // that of the Euclidean metric
  switch (source_.by) {
    case ColourBy::subdomain:
      return category(source_.mesh.tet_refs[tet]);
    case ColourBy::quality:
      for (std::size_t i = 0; i < 4; ++i) {
        points[i] = source_.mesh.points[vertices[i]];
        if (!source_.log_metrics.empty()) log_metrics[i] = source_.log_metrics[vertices[i]];
      }
      return meshing::mean_ratio(points, log_metrics);
    default:
      return off_length(vertices);
  }
}

Facet Colouring::facet(const ShownFace& face) const {
  Facet facet;
  for (std::size_t i = 0; i < 3; ++i) facet.corners[i] = source_.mesh.points[face.vertices[i]];
  const auto& [a, b, c] = face.vertices;
  const bool has_tet = face.tet != kNoNeighbour;
  const auto constant = [&facet](double value) { facet.values = {value, value, value}; };
  switch (source_.by) {
    case ColourBy::none:
      constant(face.inside ? 1 : 0);
      break;
    case ColourBy::ref:
      constant(face.inside ? static_cast<double>(refs_.size()) : face.ref ? category(*face.ref) : kMissing);
      break;
    case ColourBy::subdomain:
    case ColourBy::quality:
      constant(has_tet ? tet_value(face.tet) : kMissing);
      break;
    case ColourBy::nonconforming: {
      const double length = has_tet ? tet_value(face.tet) : off_length(face.vertices);
      constant(length < kShortestUnit || length > kLongestUnit ? 1 : 0);
      break;
    }
    case ColourBy::length:
      facet.values = {edge_length(b, c), edge_length(c, a), edge_length(a, b)};
      facet.blend = Blend::nearest_edge;
      break;
    case ColourBy::field:
      facet.values = {source_.field[a], source_.field[b], source_.field[c]};
      facet.blend = Blend::linear;
  }
  return facet;
}

void Colouring::append(const Section& section, std::vector<Facet>& facets) const {
  const auto value = [&](const Section::Corner& corner) {
    const double from = source_.field[corner.from];
    return from + corner.share * (source_.field[corner.to] - from);
  };
  // As for a face of this tet that the cut has laid bare; the corners and a field are the section's own.
  const auto& [a, b, c, d] = source_.mesh.tets[section.tet];
  Facet facet = this->facet({{a, b, c}, section.tet, {}, true});
  facet.lit = false;  // all of the section faces the same way: its colours can be those of the scale
  if (source_.by == ColourBy::length) {
    facet.values[0] = tet_value(section.tet);
    facet.blend = Blend::constant;
  }
  for (std::size_t second = 1; second + 1 < static_cast<std::size_t>(section.size); ++second) {
    const std::array<std::size_t, 3> places = {0, second, second + 1};
    for (std::size_t i = 0; i < 3; ++i) {
      facet.corners[i] = corner_of(source_.mesh, section.corners[places[i]]);
      if (source_.by == ColourBy::field) facet.values[i] = value(section.corners[places[i]]);
    }
    // A quadrilateral's diagonal is no edge.
    facet.edges = {true, section.size == 3 || second == 2, section.size == 3 || second == 1};
    facets.push_back(facet);
  }
}

std::vector<Colour> Colouring::category_colours(const Theme& theme) const {
  if (source_.by == ColourBy::none) return {theme.surface, theme.inside};
  if (source_.by == ColourBy::nonconforming) return {theme.conforming, theme.attention};
  std::vector<Colour> colours;
  for (std::size_t i = 0; i < refs_.size(); ++i) colours.push_back(category_colour(i));
  if (source_.by == ColourBy::ref) colours.push_back(theme.conforming);
  return colours;
}

Legend Colouring::category_legend(std::span<const Facet> facets, const meshing::RefNames& names,
                                  const Theme& theme) const {
  Legend legend;
  legend.scale = {ColourScale::Kind::discrete, 0, 1, category_colours(theme), theme.surface};
  if (source_.by == ColourBy::none) return legend;
  if (source_.by == ColourBy::nonconforming) {
    legend.title = "edges in the metric";
    legend.entries = {{0, "all within [1/√2, √2]"}, {1, "one outside"}};
    return legend;
  }
  std::vector<bool> used(legend.scale.colours.size());
  for (const Facet& facet : facets)
    if (!std::isnan(facet.values[0])) used[static_cast<std::size_t>(facet.values[0])] = true;
  const bool of_tets = source_.by == ColourBy::subdomain;
  legend.title = of_tets ? "subdomain" : "reference";
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i])
      legend.entries.push_back({i, i < refs_.size() ? name_of(names, of_tets ? 3 : 2, refs_[i]) : "inside"});
  return legend;
}

Legend Colouring::continuous_legend(std::span<const Facet> facets, const Theme& theme) const {
  const auto scale = [&theme](ColourScale::Kind kind, double lo, double hi, std::span<const Colour> colours) {
    return ColourScale{kind, lo, hi, {colours.begin(), colours.end()}, theme.surface};
  };
  Legend legend;
  if (source_.by == ColourBy::quality) {
    legend.title = source_.log_metrics.empty() ? "mean ratio" : "mean ratio in the metric";
    legend.scale = scale(ColourScale::Kind::linear, 0, 1, viridis());
  } else if (source_.by == ColourBy::length) {
    legend.title = "length in the metric";
    legend.scale = scale(ColourScale::Kind::logarithmic, 0.5, 2, blue_to_red());
  } else {
    const auto [lo, hi] = extent(facets);
    legend.title = source_.field_name;
    legend.scale = scale(ColourScale::Kind::linear, lo, hi, viridis());
  }
  return legend;
}

Legend Colouring::legend(std::span<const Facet> facets, const meshing::RefNames& names, const Theme& theme,
                         const std::optional<std::pair<double, double>>& range) const {
  if (is_discrete(source_.by)) return category_legend(facets, names, theme);
  Legend legend = continuous_legend(facets, theme);
  if (range) std::tie(legend.scale.lo, legend.scale.hi) = *range;
  const double lo = legend.scale.lo, hi = legend.scale.hi;
  if (source_.by == ColourBy::length && !range)
    legend.ticks = {{0.5, "1/2"}, {kShortestUnit, "1/√2"}, {1, "1"}, {kLongestUnit, "√2"}, {2, "2"}};
  else
    legend.ticks = linear_ticks(lo, hi, 6);
  if (legend.ticks.empty()) legend.ticks = {{lo, fmt::format("{:.6g}", lo)}};
  return legend;
}

}  // namespace weft::picture
