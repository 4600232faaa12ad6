// What all examples share: options, figures as JSON, and a file of the result that tests read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace weft::examples {

/// What the numbers mean is the example's.
struct Options {
  int size = 0;   ///< points a side, rows of the matrix, particles
  int tile = 0;   ///< points or rows a block; cells a side
  int steps = 0;  ///< in time; 0: the program has none
  int threads = 1;
  std::string balancer = {};  ///< by name; empty: the program takes none
  std::string out = {};       ///< file of the result; empty: none is written
};

/// The command line's, which has `defaults` and says of them what `about` says; no --steps and no --balancer
/// where `defaults` has none. Ends the program at --help, or where something is wrong.
Options options_of(int argc, char** argv, const std::string& about, Options defaults);

/// Doubles in a file, of which each rank writes its own.
class ResultFile {
 public:
  /// Empty: nothing is written. Throws std::runtime_error.
  explicit ResultFile(const std::string& path);
  ~ResultFile();
  ResultFile(const ResultFile&) = delete;
  ResultFile& operator=(const ResultFile&) = delete;

  /// `values` stand from the double number `first` on.
  void put(std::size_t first, std::span<const double> values);

 private:
  int file_ = -1;
};

double wall_clock();         ///< seconds
double processor_seconds();  ///< of this process, all threads

/// What a version took, all ranks together.
struct Figures {
  double seconds = 0;    ///< wall time
  double processor = 0;  ///< seconds
  std::uint64_t tasks = 0;
  std::uint64_t messages = 0;  ///< between ranks
  std::uint64_t bytes = 0;     ///< of these
  std::uint64_t moves = 0;     ///< of objects between ranks
};

/// One line of JSON.
void print(const std::string& program, int ranks, const Options& options, const Figures& figures);

}  // namespace weft::examples
