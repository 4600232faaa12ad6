// Draws the bar or prints the lines.
#include "tools/weft/terminal/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/weft/terminal/text.h"

namespace weft::tools {

using graph::adaptation::RunProgress;

namespace {

constexpr double kSecondsBetweenLines = 2;
constexpr int kBarWidth = 30;

int terminal_width() {
  constexpr int kUsual = 80;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

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

Progress::Progress(ProgressStyle style)
    : form_(style == ProgressStyle::none                                 ? Form::nothing
            : style == ProgressStyle::automatic && isatty(STDERR_FILENO) ? Form::bar
                                                                         : Form::lines) {}

Progress::~Progress() { finish(); }

double Progress::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void Progress::update(const std::string& stage, double done, std::uint64_t tets) {
  done = done_ = std::clamp(done, done_, 1.0);
  if (form_ == Form::bar) draw_bar(stage, done, tets);
  if (form_ == Form::lines) print_line(stage, done, tets);
}

void Progress::draw_bar(const std::string& stage, double done, std::uint64_t tets) {
  const int filled = static_cast<int>(done * kBarWidth);
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kBarWidth - filled), '.');
  const std::string count = tets > 0 ? grouped(tets) + " tets" : "";
  fmt::print(stderr, "\r{:<16.16} [{}] {:>3.0f} %  {:>18}  {:>9}\033[K", stage, bar, 100 * done, count,
             seconds_text(seconds()));
  std::fflush(stderr);
  bar_drawn_ = true;
}

bool Progress::line_is_due() {
  if (seconds() < next_line_) return false;
  constexpr double kShareOfTime = 0.02;  // a run of days must not fill its log
  next_line_ = seconds() + std::max(kSecondsBetweenLines, kShareOfTime * seconds());
  return true;
}

void Progress::print_line(const std::string& stage, double done, std::uint64_t tets) {
  if (line_is_due()) say(stage, done, tets);
}

void Progress::phase(const std::string& name) {
  if (form_ == Form::bar) {
    fmt::print(stderr, "\r{} ...\033[K", name);
    std::fflush(stderr);
    bar_drawn_ = true;
  }
  if (form_ == Form::lines && seconds() >= kSecondsBetweenLines && line_is_due())
    fmt::print(stderr, "weft: {}, {}\n", name, seconds_text(seconds()));
}

void Progress::say(const std::string& stage, double done, std::uint64_t tets) {
  done = done_ = std::clamp(done, done_, 1.0);
  finish();
  const std::string count = tets > 0 ? ", " + grouped(tets) + " tets" : "";
  fmt::print(stderr, "weft: {} {:.0f} %{}, {}\n", stage, 100 * done, count, seconds_text(seconds()));
}

void Progress::update(const RunProgress& progress) {
  if (form_ == Form::nothing || (form_ == Form::lines && !line_is_due())) return;
  const std::string line = text_of(progress);
  if (form_ == Form::lines) return fmt::print(stderr, "weft: {}\n", line);
  fmt::print(stderr, "\r{:.{}}\033[K", line, terminal_width() - 1);  // a wrapped line cannot be drawn over
  std::fflush(stderr);
  bar_drawn_ = true;
}

void Progress::finish() {
  if (!bar_drawn_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  bar_drawn_ = false;
}

}  // namespace weft::tools
