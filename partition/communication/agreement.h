// Failures that all ranks learn of: either all go on or all throw the same.
#pragma once

#include <exception>
#include <string>

#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks: throws meshing::InputError with the complaint of the lowest rank that has one (not empty).
void agree(Peers& peers, const std::string& complaint);

/// All ranks: runs action(), which talks to no peer, and then agrees on the exceptions it threw.
template <class Action>
void agree_on(Peers& peers, const Action& action) {
  std::string complaint;
  try {
    action();
  } catch (const std::exception& error) {
    complaint = error.what();
    if (complaint.empty()) complaint = "unknown error";
  }
  agree(peers, complaint);
}

/// All ranks: the text of rank 0.
std::string text_of_first(Peers& peers, const std::string& text);

}  // namespace weft::partition
