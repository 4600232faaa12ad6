// Sorted once, looked up by vertex.
#include "partition/shift/colouring.h"

#include <algorithm>
#include <bit>

#include "meshing/base/place_in.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

Priority priority_in(std::uint64_t round, SubdomainId subdomain, std::uint64_t poor_tets, bool full) {
  constexpr int kBitsOfDraw = 57;  // the rest is 0 or, for the binary digits of a count, 1 to 65
  const std::uint64_t name =
      GlobalId::derived_from(GlobalId(subdomain, 0), GlobalId(SubdomainId(0), round + 1)).value();
  const std::uint64_t draw = name << 1;  // the highest bit is that of all derived names
  const std::uint64_t place = full ? 0 : 1 + static_cast<std::uint64_t>(std::bit_width(poor_tets));
  return {place << kBitsOfDraw | draw >> (64 - kBitsOfDraw), subdomain};
}

ReceiverOrder::ReceiverOrder(const Priority& self, std::span<const Priority> neighbours) : order_{self} {
  order_.insert(order_.end(), neighbours.begin(), neighbours.end());
  std::sort(order_.begin(), order_.end());
  const auto find = [&](const Priority& p) { return static_cast<Place>(meshing::place_in(order_, p)) + 1; };
  self_ = find(self);
  for (const Priority& neighbour : neighbours) {
    ids_.push_back(neighbour.id);
    place_.push_back(find(neighbour));
  }
}

ReceiverOrder::Place ReceiverOrder::place_of(SubdomainId neighbour) const {
  return place_[meshing::place_in(ids_, neighbour)];
}

ReceiverOrder::Place ReceiverOrder::receiver(std::span<const Holder> others) const {
  Place first = self_;
  for (const Holder& h : others) first = std::max(first, place_of(h.subdomain));
  return first;
}

}  // namespace weft::partition
