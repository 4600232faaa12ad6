// Places of text that many write into one file.
#pragma once

#include <cstdint>
#include <vector>

#include "partition/communication/peers.h"

namespace weft::partition {

/// The text of one part in each section of a file, in bytes.
struct TextLengths {
  std::uint64_t order;  ///< where the part stands among all
  std::vector<std::uint64_t> sections;
};

/// Where text goes: one section after the other, each with its head and then the rows of all parts.
struct TextPlaces {
  std::vector<std::uint64_t> heads;              ///< of the sections
  std::vector<std::vector<std::uint64_t>> rows;  ///< of each part here in each section
};

/// All ranks: places for the parts here; the heads' lengths are alike on all.
TextPlaces place_text(Peers& peers, const std::vector<std::uint64_t>& heads,
                      const std::vector<TextLengths>& parts);

}  // namespace weft::partition
