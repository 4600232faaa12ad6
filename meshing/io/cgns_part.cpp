// What the part of weft for CGNS offers: its one function.
#include "meshing/io/cgns_part.h"

extern "C" __attribute__((visibility("default"))) const void* weft_cgns_part(int interface) {
  using namespace weft::meshing;
  static constexpr CgnsPart part = {.read = read_cgns,
                                    .write = write_cgns,
                                    .size = cgns_size,
                                    .read_range = read_cgns_range,
                                    .piece_sizes = cgns_piece_sizes,
                                    .read_piece_ranges = read_cgns_piece_ranges,
                                    .read_piece_fields = read_cgns_piece_fields,
                                    .begin_parts = begin_cgns_parts,
                                    .open_part = open_cgns_part};
  return interface == kCgnsInterface ? &part : nullptr;
}
