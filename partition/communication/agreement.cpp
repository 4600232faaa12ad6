// Texts to and from all ranks.
#include "partition/communication/agreement.h"

#include <vector>

#include "meshing/base/error.h"

namespace weft::partition {

void agree(Peers& peers, const std::string& complaint) {
  const std::vector<char> mine(complaint.begin(), complaint.end());
  for (const std::vector<char>& text : allgather(peers, mine)) {
    if (!text.empty()) throw meshing::InputError("", "", std::string(text.begin(), text.end()));
  }
}

std::string text_of_first(Peers& peers, const std::string& text) {
  std::vector<char> mine;
  if (peers.rank() == 0) mine.assign(text.begin(), text.end());
  const std::vector<char> first = allgather(peers, mine).front();
  return {first.begin(), first.end()};
}

}  // namespace weft::partition
