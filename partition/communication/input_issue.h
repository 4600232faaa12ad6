// Errors in the input that one rank finds and all must report alike.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "partition/communication/peers.h"

namespace weft::partition {

/// What is wrong with an entity. The least `order` is reported.
struct InputIssue {
  std::array<std::uint64_t, 3> order{};
  std::string entity, reason;
};

/// Keeps the least.
void keep_least(std::optional<InputIssue>& least, InputIssue issue);

/// Every rank throws meshing::InputError of the least of all ranks' issues; returns where there is none.
void throw_first(Peers& peers, const std::optional<InputIssue>& issue);

}  // namespace weft::partition
