// Texts to and from all ranks.
#include "partition/communication/agreement.h"

#include <cstdint>
#include <cstring>
#include <utility>

#include "meshing/base/error.h"

namespace weft::partition {
namespace {

/// Of the ranks that have one, on all; empty where none has. In each message a rank and one text travel.
std::string text_of_lowest(Peers& peers, bool has, const std::string& text) {
  std::uint32_t rank = has ? static_cast<std::uint32_t>(peers.rank()) : ~std::uint32_t{0};
  const auto rank_in = [](const Bytes& bytes) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  };
  Bytes mine(sizeof rank + (has ? text.size() : 0));
  std::memcpy(mine.data(), &rank, sizeof rank);
  if (has && !text.empty()) std::memcpy(mine.data() + sizeof rank, text.data(), text.size());
  const Bytes lowest = peers.reduce(std::move(mine), [&](Bytes& least, const Bytes& other) {
    if (rank_in(other) < rank_in(least)) least = other;
  });
  return {reinterpret_cast<const char*>(lowest.data()) + sizeof rank, lowest.size() - sizeof rank};
}

}  // namespace

void throw_issue(const std::string& issue) { throw meshing::InputError("", "", issue); }

void agree(Peers& peers, const std::string& issue) {
  const std::string first = first_text(peers, issue);
  if (!first.empty()) throw_issue(first);
}

std::string first_text(Peers& peers, const std::string& text) {
  return text_of_lowest(peers, !text.empty(), text);
}

std::string text_of_first(Peers& peers, const std::string& text) {
  return text_of_lowest(peers, peers.rank() == 0, text);
}

}  // namespace weft::partition
