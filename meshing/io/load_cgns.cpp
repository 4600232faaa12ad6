// The loaded part of weft for CGNS.
#include "meshing/base/error.h"
#include "meshing/base/load_part.h"
#include "meshing/io/cgns_part.h"

namespace weft::meshing {

const CgnsPart& cgns_part(const std::filesystem::path& path) {
  constexpr const char* kFile = "libweft_cgns.so";
  static const Part part = load_part(kFile, kCgnsEntryName, kCgnsInterface);
  if (part.offer) return *static_cast<const CgnsPart*>(part.offer);
  throw InputError(path.string(), "", missing_part_text(part, kFile, "CGNS", "libcgns3.4"));
}

}  // namespace weft::meshing
