// One error for all ranks.
#include "partition/communication/input_issue.h"

#include <utility>

#include "meshing/base/error.h"
#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using Order = std::array<std::uint64_t, 4>;  // present (0) or not (1), then InputIssue::order

Bytes bytes_of(const std::string& text) {
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}

std::string text_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Text that one rank has, on all; empty on the others.
std::string spread(Peers& peers, const std::string& text) {
  std::string found;
  for (const Bytes& bytes :
       peers.all_to_all(std::vector<Bytes>(static_cast<std::size_t>(peers.ranks()), bytes_of(text))))
    if (!bytes.empty()) found = text_of(bytes);
  return found;
}

}  // namespace

void keep_least(std::optional<InputIssue>& least, InputIssue complaint) {
  if (!least || complaint.order < least->order) least = std::move(complaint);
}

void throw_first(Peers& peers, const std::optional<InputIssue>& complaint) {
  Order mine{1, 0, 0, 0};
  if (complaint) mine = {0, complaint->order[0], complaint->order[1], complaint->order[2]};
  const auto orders = allgather(peers, std::vector<Order>{mine});
  std::size_t least = 0;
  for (std::size_t r = 1; r < orders.size(); ++r)
    if (orders[r][0] < orders[least][0]) least = r;
  if (orders[least][0][0] == 1) return;
  const bool is_mine = least == static_cast<std::size_t>(peers.rank());
  const std::string entity = spread(peers, is_mine ? complaint->entity : "");
  const std::string reason = spread(peers, is_mine ? complaint->reason : "");
  throw meshing::InputError("", entity, reason);
}

}  // namespace weft::partition
