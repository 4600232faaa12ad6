// Draws the bar or prints the lines.
#include "tools/weft/terminal/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/common/text.h"

namespace weft::tools {

namespace {

constexpr double kSecondsBetweenLines = 2;
constexpr int kBarWidth = 30;

int terminal_width() {
  constexpr int kUsual = 80;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

}  // namespace

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
  const std::string count = tets > 0 ? counted(tets, "tet") : "";
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
  const std::string count = tets > 0 ? ", " + counted(tets, "tet") : "";
  fmt::print(stderr, "weft: {} {:.0f} %{}, {}\n", stage, 100 * done, count, seconds_text(seconds()));
}

void Progress::sentence(const std::string& text) {
  if (form_ == Form::nothing || (form_ == Form::lines && !line_is_due())) return;
  if (form_ == Form::lines) return fmt::print(stderr, "weft: {}\n", text);
  fmt::print(stderr, "\r{:.{}}\033[K", text, terminal_width() - 1);  // a wrapped line cannot be drawn over
  std::fflush(stderr);
  bar_drawn_ = true;
}

void Progress::show(const weft::Progress& progress) {
  if (progress.sentence)
    sentence(progress.stage);
  else
    update(progress.stage, progress.done, progress.tets);
}

void Progress::finish() {
  if (!bar_drawn_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  bar_drawn_ = false;
}

}  // namespace weft::tools
