// One error for all ranks.
#include "partition/communication/input_issue.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include "meshing/base/error.h"

namespace weft::partition {
namespace {

/// What is compared first: 0 where there is one and 1 where not, InputIssue::order, the rank; then lengths
/// of the texts, which follow.
using Head = std::array<std::uint64_t, 7>;
constexpr std::size_t kCompared = 5;

Bytes packed(const std::optional<InputIssue>& issue, int rank) {
  Head head{1, 0, 0, 0, static_cast<std::uint64_t>(rank), 0, 0};
  std::string texts;
  if (issue) {
    head = {0,       issue->order[0],      issue->order[1],     issue->order[2],
            head[4], issue->entity.size(), issue->reason.size()};
    texts = issue->entity + issue->reason;
  }
  Bytes bytes(sizeof head + texts.size());
  std::memcpy(bytes.data(), head.data(), sizeof head);
  if (!texts.empty()) std::memcpy(bytes.data() + sizeof head, texts.data(), texts.size());
  return bytes;
}

Head head_of(const Bytes& bytes) {
  Head head;
  std::memcpy(head.data(), bytes.data(), sizeof head);
  return head;
}

}  // namespace

void keep_least(std::optional<InputIssue>& least, InputIssue issue) {
  if (!least || issue.order < least->order) least = std::move(issue);
}

void throw_first(Peers& peers, const std::optional<InputIssue>& issue) {
  const Bytes least = peers.reduce(packed(issue, peers.rank()), [](Bytes& first, const Bytes& other) {
    const Head a = head_of(first), b = head_of(other);
    if (std::lexicographical_compare(b.begin(), b.begin() + kCompared, a.begin(), a.begin() + kCompared))
      first = other;
  });
  const Head head = head_of(least);
  if (head[0] == 1) return;
  const char* texts = reinterpret_cast<const char*>(least.data()) + sizeof head;
  throw meshing::InputError("", {texts, head[5]}, {texts + head[5], head[6]});
}

}  // namespace weft::partition
