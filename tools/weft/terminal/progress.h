// Tells on stderr how far a run is: a bar on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "weft/weft.h"

namespace weft::tools {

enum class ProgressStyle { automatic, plain, none };

class Progress {
 public:
  explicit Progress(ProgressStyle style);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Share of the time that is over, in [0, 1] (never shown to descend), and tets now (0: not known). Prints
  /// at most one plain line in two seconds.
  void update(const std::string& stage, double done, std::uint64_t tets);
  /// A sentence instead.
  void sentence(const std::string& text);
  /// Whichever the library tells.
  void show(const weft::Progress& progress);
  /// A phase has begun of a command without percentages: told on a terminal at once, else only after two
  /// seconds.
  void phase(const std::string& name);
  /// A line at once, whatever the style.
  void say(const std::string& stage, double done, std::uint64_t tets);
  /// Takes the bar off the terminal, so that the summary starts on a clean line.
  void finish();

 private:
  enum class Form { bar, lines, nothing };
  using Clock = std::chrono::steady_clock;

  double seconds() const;
  void draw_bar(const std::string& stage, double done, std::uint64_t tets);
  void print_line(const std::string& stage, double done, std::uint64_t tets);
  bool line_is_due();

  Form form_;
  Clock::time_point start_ = Clock::now();
  double done_ = 0;       ///< the largest share so far
  double next_line_ = 0;  ///< seconds from the start before which no further line is printed
  bool bar_drawn_ = false;
};

}  // namespace weft::tools
