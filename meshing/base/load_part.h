// Parts of weft that are libraries of their own, loaded when they are first needed: a run without them loads
// none of the libraries that they use.
#pragma once

#include <string>

namespace weft::meshing {

/// The one function of a part. `interface` is the number of the interface that the caller knows; null is
/// returned for another.
using PartEntry = const void* (*)(int interface);

struct Part {
  const void* offer = nullptr;  ///< what its function returns
  std::string reason;           ///< why there is none; empty where there is no such file
};

/// Loads the library `file`, which has the function `entry`; it stays until the end of the program.
Part load_part(const char* file, const char* entry, int interface);

/// Why there is no offer of a part that every weft has: `uses` is the library that it needs, and `package`
/// who brings that library.
std::string missing_part_text(const Part& part, const char* file, const char* uses, const char* package);

}  // namespace weft::meshing
