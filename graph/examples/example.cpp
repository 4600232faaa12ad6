// Options by CLI11, figures by nlohmann.
#include "graph/examples/example.h"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <stdexcept>

#include "engine/json/json.h"

namespace weft::examples {
Options options_of(int argc, char** argv, const std::string& about, Options defaults) {
  CLI::App app(about);
  Options options = std::move(defaults);
  app.add_option("--size", options.size)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--tile", options.tile)->check(CLI::PositiveNumber)->capture_default_str();
  if (options.steps > 0)
    app.add_option("--steps", options.steps)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--threads", options.threads, "of each rank")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  if (!options.balancer.empty()) app.add_option("--balancer", options.balancer)->capture_default_str();
  app.add_option("--out", options.out, "file for the result, doubles of this machine");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  return options;
}

ResultFile::ResultFile(const std::string& path) {
  if (path.empty()) return;
  file_ = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) throw std::runtime_error(path + ": " + std::strerror(errno));
}

ResultFile::~ResultFile() {
  if (file_ >= 0) close(file_);
}

void ResultFile::put(std::size_t first, std::span<const double> values) {
  if (file_ < 0) return;
  const auto bytes = static_cast<ssize_t>(values.size_bytes());
  if (pwrite(file_, values.data(), values.size_bytes(), static_cast<off_t>(first * sizeof(double))) != bytes)
    throw std::runtime_error(std::string("the result cannot be written: ") + std::strerror(errno));
}

double wall_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void print(const std::string& program, int ranks, const Options& options, const Figures& figures) {
  const nlohmann::ordered_json line{{"program", program},         {"ranks", ranks},
                                    {"threads", options.threads}, {"size", options.size},
                                    {"tile", options.tile},       {"steps", options.steps},
                                    {"seconds", figures.seconds}, {"processor_seconds", figures.processor},
                                    {"tasks", figures.tasks},     {"messages", figures.messages},
                                    {"bytes", figures.bytes},     {"moves", figures.moves}};
  std::printf("%s\n", line.dump().c_str());
}

}  // namespace weft::examples
