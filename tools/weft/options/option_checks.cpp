// The checks: each returns what is wrong, or nothing.
#include "tools/weft/options/option_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include "weft/weft.h"

namespace weft::tools {
namespace {

std::optional<double> finite_value(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool good = end != text.c_str() && *end == '\0' && std::isfinite(value);
  return good ? std::optional(value) : std::nullopt;
}

CLI::Validator validator(std::string (*problem)(const std::string&)) {
  return CLI::Validator([problem](const std::string& text) { return problem(text); }, "");
}

}  // namespace

CLI::Validator finite_number() {
  return validator([](const std::string& text) -> std::string {
    return finite_value(text) ? "" : "'" + text + "' is not a number";
  });
}

CLI::Validator positive_number() {
  return validator([](const std::string& text) -> std::string {
    return finite_value(text).value_or(-1) > 0 ? "" : "'" + text + "' is not a number above zero";
  });
}

CLI::Validator number_from_one() {
  return validator([](const std::string& text) -> std::string {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    const bool good = end != text.c_str() && *end == '\0' && value >= 1;
    return good ? "" : "'" + text + "' is not a number from 1 up";
  });
}

CLI::Validator number_or_auto() {
  return validator([](const std::string& text) -> std::string {
    const bool digits =
        !text.empty() && text.size() < 7 && text.find_first_not_of("0123456789") == std::string::npos;
    return digits || text == "auto" ? "" : "'" + text + "' is neither a number nor auto";
  });
}

CLI::Validator mesh_output_name() {
  return validator([](const std::string& text) -> std::string {
    return is_mesh_name(text) ? "" : "'" + text + "' must end in " + mesh_extensions();
  });
}

CLI::Validator volume_output_name() {
  return validator([](const std::string& text) -> std::string {
    const bool good = is_mesh_name(text) && holds_volumes(text);
    return good ? "" : "'" + text + "' must end in " + volume_extensions();
  });
}

CLI::Validator solution_name() {
  return validator([](const std::string& text) -> std::string {
    const auto extension = std::filesystem::path(text).extension();
    return extension == ".solb" || extension == ".sol" ? "" : "'" + text + "' must end in .solb or .sol";
  });
}

CLI::Validator picture_name() {
  return validator([](const std::string& text) -> std::string {
    return is_picture_name(text) ? "" : "'" + text + "' must end in .png, .svg or .pdf";
  });
}

int default_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

void add_threads(CLI::App& command, int& threads) {
  threads = default_threads();
  command.add_option("--threads", threads, "threads; default: the cores of this machine")
      ->type_name("T")
      ->check(CLI::Range(1, 1024).description(""));
}

}  // namespace weft::tools
