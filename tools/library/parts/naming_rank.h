// What is wrong on one rank is thrown on all, saying where.
#pragma once

#include <string>

#include "meshing/base/error.h"
#include "partition/communication/agreement.h"
#include "partition/communication/peers.h"

namespace weft::tools {

/// All ranks: call() on each; the error of the lowest rank that has one is thrown on all, naming the rank.
template <class Call>
void agree_naming_rank(partition::Peers& peers, const Call& call) {
  std::string issue;
  try {
    call();
  } catch (const meshing::InputError& error) {
    issue = "rank " + std::to_string(peers.rank()) + ": " + error.what();
  }
  partition::agree(peers, issue);
}

}  // namespace weft::tools
