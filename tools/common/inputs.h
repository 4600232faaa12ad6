// Files that are read are not to be replaced.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
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

/// The files that the .pvtu `index` names; none of any other file, and of one that cannot be read.
inline std::vector<std::string> pieces_named_by(const std::string& index) {
  const std::filesystem::path path(index);
  if (path.extension() != ".pvtu") return {};
  std::ifstream in(path);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const std::string attribute = "Source=";
  std::vector<std::string> pieces;
  for (std::size_t at = text.find(attribute); at != std::string::npos; at = text.find(attribute, at)) {
    at += attribute.size();
    const std::size_t end = at < text.size() ? text.find(text[at], at + 1) : std::string::npos;
    if (end == std::string::npos) break;
    pieces.push_back((path.parent_path() / text.substr(at + 1, end - at - 1)).string());
  }
  return pieces;
}

/// Throws OptionError where `output`, called `name` and given by `option`, is one of the inputs or of their
/// pieces, or has one as a piece.
inline void keep_inputs(const std::string& output, const std::string& name,
                        const std::vector<std::string>& inputs, const std::string& option = "--out") {
  for (const std::string& input : inputs) {
    std::vector<std::string> files = pieces_named_by(input);
    files.insert(files.begin(), input);
    for (const std::string& file : files)
      if (same_file(output, file) || is_piece_of(output, file))
        throw OptionError(option, name + " would replace the input " + file);
  }
}

}  // namespace weft::tools
