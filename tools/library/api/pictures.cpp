// Pictures by the words of `weft view`.
#include <fmt/format.h>

#include <map>
#include <stdexcept>
#include <utility>

#include "meshing/base/error.h"
#include "tools/common/text.h"
#include "tools/library/api/require.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/outputs.h"
#include "tools/library/pictures/picture_options.h"
#include "tools/picture/histogram_plot.h"
#include "tools/picture/mesh_picture.h"
#include "weft/weft.h"

namespace weft {
namespace {

using picture::ColourBy;
using tools::numbers_in;

ColourBy colour_by(const std::string& word) {
  static const std::map<std::string, ColourBy> all = {
      {"none", ColourBy::none},           {"ref", ColourBy::ref},
      {"subdomain", ColourBy::subdomain}, {"quality", ColourBy::quality},
      {"length", ColourBy::length},       {"nonconforming", ColourBy::nonconforming},
      {"field", ColourBy::field}};
  const auto found = all.find(word);
  if (found != all.end()) return found->second;
  throw OptionError("--color-by", "'" + word +
                                      "' is not one of none, ref, subdomain, quality, length, nonconforming, "
                                      "deviation, field and field:NAME");
}

/// Returns parse(), with what it finds wrong told as the fault of `option`.
template <class Parse>
auto parsed(const char* option, const Parse& parse) {
  try {
    return parse();
  } catch (const std::invalid_argument& error) {
    throw OptionError(option, error.what());
  }
}

picture::View view_of(const PictureOptions& words) {
  const Point toward_eye = parsed("--from", [&] { return picture::direction_named(words.from); });
  if (words.up.empty()) return {toward_eye, picture::default_up(toward_eye)};
  const Point up = parsed("--up", [&] { return picture::direction_named(words.up); });
  if (!(norm(cross(up, toward_eye)) > 0))
    throw OptionError("--up", "'" + words.up + "' is parallel to the view direction --from");
  return {toward_eye, up};
}

std::pair<double, double> range_of(const std::string& text) {
  const std::vector<double> ends = numbers_in(text, 2);
  if (!(ends[0] < ends[1])) throw std::invalid_argument("'" + text + "' does not ascend");
  return {ends[0], ends[1]};
}

void read_range(const PictureOptions& words, ColourBy by, picture::PictureOptions& options) {
  if (words.range.empty()) return;
  const bool continuous = by == ColourBy::quality || by == ColourBy::length || by == ColourBy::field;
  if (!continuous) throw OptionError("--range", "is for --color-by quality, length and field");
  options.range = parsed("--range", [&] { return range_of(words.range); });
  if (by == ColourBy::length && !(options.range->first > 0))
    throw OptionError("--range", "lengths are above zero");
}

void read_cut(const PictureOptions& words, picture::PictureOptions& options) {
  if (words.clip.empty()) return;
  options.cut = parsed("--clip", [&] { return tools::plane_in(words.clip, options.view.toward_eye); });
  if (words.flip) options.cut = {-1 * options.cut->normal, -options.cut->offset};
  options.planar = words.slice;
}

picture::PictureOptions options_of(const PictureOptions& words) {
  require_positive("--zoom", words.zoom);
  require_positive("--line-width", words.line_width);
  const ColourBy by = colour_by(words.color_by);
  picture::PictureOptions options;
  std::tie(options.width, options.height) = parsed("--size", [&] { return tools::picture_size(words.size); });
  if (words.dark) options.theme = picture::dark_theme();
  options.title = words.title;
  options.zoom = words.zoom;
  options.line_width = words.edges ? words.line_width : 0;
  options.legend = words.legend;
  options.axes = words.axes;
  options.view = view_of(words);
  if (!words.focus.empty()) options.focus = parsed("--focus", [&] { return tools::box_in(words.focus); });
  if (!words.only.empty()) options.only = words.only;
  read_range(words, by, options);
  read_cut(words, options);
  return options;
}

void check_source(const PictureSource& source, ColourBy by) {
  const bool by_length = by == ColourBy::length || by == ColourBy::nonconforming;
  if (by_length && !source.metric) throw OptionError("--color-by", "needs a metric");
  if (source.metric) check_length(source.mesh, source.metric->size(), "metric");
  if (by == ColourBy::field) check_length(source.mesh, source.field.size(), "field");
}

}  // namespace

bool is_picture_name(const std::string& path) { return picture::Canvas::format_of(path).has_value(); }

PictureSize check_picture(const PictureOptions& options) {
  const picture::PictureOptions read = options_of(options);
  return {read.width, read.height};
}

void draw(const std::string& path, const PictureSource& source, const PictureOptions& options) {
  const picture::PictureOptions read = options_of(options);
  const ColourBy by = colour_by(options.color_by);
  const WholeMesh whole(source.mesh);
  check_source(source, by);
  const RefNames no_names;
  const std::vector<Tensor> no_metric;
  const std::vector<Tensor>& metric = source.metric ? source.metric->logarithms() : no_metric;
  const picture::ColourSource colours{by, *whole, metric, source.field, source.field_name};
  tools::write_text(path, picture::mesh_picture(colours, source.names ? *source.names : no_names, read,
                                                tools::picture_format(path)));
}

void draw_histograms(const std::string& path, const Measures& measures, const HistogramText& text) {
  tools::write_text(path, picture::histogram_plot(measures, {text.title, text.tets, text.edges},
                                                  tools::picture_format(path)));
}

void draw_histograms(const std::string& path, const Measures& m, const std::string& title) {
  using tools::grouped, tools::percent;
  if (m.num_tets == 0) throw InputError("", "", "there are no tets to plot");
  draw_histograms(
      path, m,
      HistogramText{title,
                    fmt::format("{} tets: mean quality {:.3f}, worst 1 % below {:.3f}, least {:.3g}",
                                grouped(m.num_tets), m.quality_mean, m.quality_q01, m.quality_min),
                    fmt::format("{} edges: {} unit (shaded), {} shorter, {} longer; from {:.3g} to {:.3g}",
                                grouped(m.num_edges), percent(m.edges_unit), percent(m.edges_short, 2),
                                percent(m.edges_long, 2), m.length_min, m.length_max)});
}

}  // namespace weft
