#include "tools/library/report/run_progress_text.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/common/text.h"

namespace weft::tools {

using graph::adaptation::RunProgress;

namespace {

/// Without the digits that an estimate does not have.
std::string about(double seconds) {
  const auto whole = static_cast<long>(std::ceil(seconds));
  return whole < 120 ? fmt::format("{} s", whole) : fmt::format("{} min", (whole + 30) / 60);
}

std::string time_left_text(const RunProgress& progress) {
  std::string text = progress.step_left ? fmt::format("this step about {} more", about(*progress.step_left))
                                        : "time left unknown";
  if (progress.all_left && progress.most_left)
    text += fmt::format(", all about {} (at most {})", about(*progress.all_left), about(*progress.most_left));
  else if (progress.step_left)
    text += ", then shifts";
  return text;
}

std::string plural(std::uint64_t n, const char* word) {
  return fmt::format("{} {}{}", grouped(n), word, n == 1 ? "" : "s");
}

}  // namespace

std::string text_of(const RunProgress& progress) {
  const meshing::Nonconforming& left = progress.left;
  std::string text = progress.step == 0
                         ? "interior"
                         : fmt::format("shift {} of at most {}", progress.step, progress.most_shifts);
  text += fmt::format(": {} of {} subdomains", progress.done, progress.subdomains);
  if (progress.at_rest > 0) text += fmt::format(" ({} at rest)", progress.at_rest);
  text += ", " + time_left_text(progress);
  if (progress.adapted > 0) {
    text +=
        fmt::format(", {}, remaining: {}, {}", plural(left.tets, "tet"),
                    plural(left.long_edges + left.short_edges, "edge"), plural(left.poor_tets, "poor tet"));
    if (progress.adapted < progress.subdomains) text += " in " + plural(progress.adapted, "subdomain");
  }
  return text + ", " + seconds_text(progress.seconds);
}

}  // namespace weft::tools
