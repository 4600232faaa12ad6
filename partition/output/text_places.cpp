// All lengths go to everyone.
#include "partition/output/text_places.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace weft::partition {
namespace {

/// Bytes of one part's rows in a section, and the part of which rank it is.
struct TextLength {
  std::uint64_t section, order, bytes, rank, part;
};

}  // namespace

TextPlaces place_text(Peers& peers, const std::vector<std::uint64_t>& heads,
                      const std::vector<TextLengths>& parts) {
  const auto rank = static_cast<std::uint64_t>(peers.rank());
  std::vector<TextLength> mine;
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (std::size_t s = 0; s < heads.size(); ++s)
      mine.push_back({s, parts[p].order, parts[p].sections[s], rank, p});
  std::vector<TextLength> all = allgather_joined(peers, mine);
  std::ranges::sort(all, {}, [](const TextLength& l) { return std::pair(l.section, l.order); });
  TextPlaces places;
  places.rows.assign(parts.size(), std::vector<std::uint64_t>(heads.size(), 0));
  std::uint64_t place = 0;
  auto length = all.begin();
  for (std::size_t s = 0; s < heads.size(); ++s) {
    places.heads.push_back(place);
    place += heads[s];
    for (; length != all.end() && length->section == s; place += length++->bytes)
      if (length->rank == rank) places.rows[length->part][s] = place;
  }
  return places;
}

}  // namespace weft::partition
