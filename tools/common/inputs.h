// Files that are read are not to be replaced, nor files that one command writes by each other.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include "weft/weft.h"

namespace weft::tools {

inline bool same_file(const std::string& a, const std::string& b) {
  std::error_code missing;
  return std::filesystem::equivalent(a, b, missing) && !missing;
}

/// Whether `file` has the name of a piece of the .pvtu `index`: wing_0.vtu of wing.pvtu.
inline bool is_piece_of(const std::string& index, const std::string& file) {
  const std::filesystem::path whole(index), piece(file);
  const std::string stem = piece.stem().string(), before = whole.stem().string() + "_";
  return whole.extension() == ".pvtu" && piece.extension() == ".vtu" && stem.starts_with(before) &&
         stem.size() > before.size() &&
         stem.find_first_not_of("0123456789", before.size()) == std::string::npos &&
         same_file((whole.parent_path() / piece.filename()).string(), file);
}

/// Throws OptionError where `output`, called `name` and given by `option`, is one of the inputs or a piece of
/// one, or has one as a piece.
inline void keep_inputs(const std::string& output, const std::string& name,
                        const std::vector<std::string>& inputs, const std::string& option = "--out") {
  for (const std::string& file : inputs)
    if (same_file(output, file) || is_piece_of(output, file) || is_piece_of(file, output))
      throw OptionError(option, name + " would replace the input " + file);
}

/// Where a file is or would be; a link leads to what it names.
inline std::filesystem::path place_of(const std::string& file) {
  std::error_code error;
  const std::filesystem::path whole =
      std::filesystem::weakly_canonical(std::filesystem::absolute(file, error), error);
  return error ? std::filesystem::path(file) : whole;
}

/// A file that a command writes, and the option that asks for it.
struct OutputFile {
  std::string option, path;
};

/// Throws OptionError where two of them are one file. None need exist; empty ones are not written.
inline void keep_apart(const std::vector<OutputFile>& outputs) {
  std::map<std::string, std::string> option_of;
  for (const OutputFile& output : outputs) {
    if (output.path.empty()) continue;
    const auto [other, is_new] = option_of.emplace(place_of(output.path).string(), output.option);
    if (!is_new)
      throw OptionError(output.option, output.path + " would be written by " + other->second + ", too");
  }
}

/// The same of a conversion, which may replace the mesh itself: it is read before it is written.
inline void keep_solution(const std::string& input, const std::string& output, const std::string& solution) {
  keep_inputs(output, "it", same_file(output, input) ? std::vector{solution} : std::vector{input, solution},
              "OUT");
}

}  // namespace weft::tools
