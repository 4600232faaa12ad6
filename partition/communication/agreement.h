// Failures that all ranks learn of: either all go on or all throw the same.
#pragma once

#include <exception>
#include <string>

#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks: throws meshing::InputError with the text of the lowest rank whose `issue` is not empty.
void agree(Peers& peers, const std::string& issue);

/// All ranks: runs action(), which talks to no peer, and then agrees on the exceptions it threw.
template <class Action>
void agree_on(Peers& peers, const Action& action) {
  std::string issue;
  try {
    action();
  } catch (const std::exception& error) {
    issue = error.what();
    if (issue.empty()) issue = "unknown error";
  }
  agree(peers, issue);
}

/// All ranks: the text of rank 0.
std::string text_of_first(Peers& peers, const std::string& text);

}  // namespace weft::partition
