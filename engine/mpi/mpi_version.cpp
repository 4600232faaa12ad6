// Asks the library.
#include "engine/mpi/mpi_version.h"

#include <mpi.h>

#include <array>

namespace weft::engine {

std::string mpi_version() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> name{};
  int length = 0, version = 0, subversion = 0;
  MPI_Get_library_version(name.data(), &length);
  MPI_Get_version(&version, &subversion);
  std::string text(name.data());
  text = text.substr(0, text.find_first_of(",\n\r"));  // what follows is about the build
  return text + " (MPI " + std::to_string(version) + "." + std::to_string(subversion) + ")";
}

}  // namespace weft::engine
