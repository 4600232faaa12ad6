// Puts a file's name in front of errors from code that was handed data and never saw a file.
#pragma once

#include <string>

#include "weft/data.h"

namespace weft::tools {

/// Returns call(); an InputError from it that does not begin with `file` is thrown again with it.
template <class Call>
auto naming(const std::string& file, const Call& call) {
  try {
    return call();
  } catch (const InputError& error) {
    const std::string text = error.what();
    if (text.starts_with(file)) throw;
    throw InputError(file, "", text);
  }
}

}  // namespace weft::tools
