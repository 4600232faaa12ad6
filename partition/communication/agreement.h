// Failures that all ranks learn of: either all go on or all throw the same.
#pragma once

#include <exception>
#include <string>

#include "partition/communication/peers.h"

namespace weft::partition {

/// All ranks: throws meshing::InputError with the text of the lowest rank whose `issue` is not empty.
void agree(Peers& peers, const std::string& issue);

/// What all ranks throw who know of the same issue.
[[noreturn]] void throw_issue(const std::string& issue);

/// The text of the exception that action() throws; empty where it throws none.
template <class Action>
std::string issue_of(const Action& action) {
  try {
    action();
  } catch (const std::exception& error) {
    const std::string issue = error.what();
    return issue.empty() ? "unknown error" : issue;
  }
  return {};
}

/// All ranks: runs action(), which talks to no peer, and then agrees on the exceptions it threw.
template <class Action>
void agree_on(Peers& peers, const Action& action) {
  agree(peers, issue_of(action));
}

/// All ranks: the text of the lowest rank that has one; empty where none has.
std::string first_text(Peers& peers, const std::string& text);

/// All ranks: the text of rank 0.
std::string text_of_first(Peers& peers, const std::string& text);

/// All ranks: what action(), called on rank 0, returns, a std::string, or the exception that it throws, as
/// agree_on() throws it; in one exchange.
template <class Action>
std::string text_of_first_or_throw(Peers& peers, const Action& action) {
  std::string text, issue;
  if (peers.rank() == 0) issue = issue_of([&] { text = action(); });
  const std::string told = text_of_first(peers, issue.empty() ? "+" + text : "-" + issue);
  if (told[0] == '-') throw_issue(told.substr(1));
  return told.substr(1);
}

}  // namespace weft::partition
