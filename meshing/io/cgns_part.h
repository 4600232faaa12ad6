// The part of weft that knows CGNS and HDF5, as the rest sees it, which loads it when such a file is read or
// written.
#pragma once

#include <filesystem>

#include "meshing/io/cgns.h"

namespace weft::meshing {

/// The functions of cgns.h.
struct CgnsPart {
  decltype(&read_cgns) read;
  decltype(&write_cgns) write;
  decltype(&cgns_size) size;
  decltype(&read_cgns_range) read_range;
  decltype(&cgns_piece_sizes) piece_sizes;
  decltype(&read_cgns_piece_ranges) read_piece_ranges;
  decltype(&read_cgns_piece_fields) read_piece_fields;
  decltype(&begin_cgns_parts) begin_parts;
  decltype(&open_cgns_part) open_part;
};

/// Throws InputError naming the file where the part cannot be loaded.
const CgnsPart& cgns_part(const std::filesystem::path& path);

inline constexpr const char* kCgnsEntryName = "weft_cgns_part";
/// Sizes of what crosses are in it: a part of another version most often has others.
inline constexpr int kCgnsInterface =
    1 + static_cast<int>(1000 * sizeof(MeshContents) + 100 * sizeof(MeshData) + 10 * sizeof(WholeMesh) +
                         sizeof(CgnsPart));

}  // namespace weft::meshing
