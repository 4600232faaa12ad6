// Tables of shared vertices.
#include "partition/subdomain/interface.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace weft::partition {

void sort_unique(std::vector<Holder>& lines) {
  if (!std::is_sorted(lines.begin(), lines.end())) std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());
}

std::vector<Holder> merge_unique(std::vector<std::vector<Holder>> lists) {
  while (lists.size() > 1) {  // pairs, then pairs of pairs
    std::size_t merged = 0;
    for (std::size_t i = 0; i < lists.size(); i += 2, ++merged) {
      std::vector<Holder> both;
      if (i + 1 == lists.size()) {
        both = std::move(lists[i]);
      } else {
        both.reserve(lists[i].size() + lists[i + 1].size());
        std::ranges::set_union(lists[i], lists[i + 1], std::back_inserter(both));
      }
      lists[merged] = std::move(both);
    }
    lists.resize(merged);
  }
  return lists.empty() ? std::vector<Holder>{} : std::move(lists.front());
}

Interface::Interface(std::vector<Holder> lines) : lines_(std::move(lines)) {
  sort_unique(lines_);
  begins_.clear();
  for (std::uint32_t i = 0; i < lines_.size(); ++i) {
    const auto neighbour = std::lower_bound(neighbours_.begin(), neighbours_.end(), lines_[i].subdomain);
    if (neighbour == neighbours_.end() || *neighbour != lines_[i].subdomain)
      neighbours_.insert(neighbour, lines_[i].subdomain);
    if (i > 0 && lines_[i].vertex == lines_[i - 1].vertex) continue;
    ids_.push_back(lines_[i].vertex);
    begins_.push_back(i);
  }
  begins_.push_back(static_cast<std::uint32_t>(lines_.size()));
  locals_.resize(ids_.size());
}

std::uint32_t Interface::find(GlobalId id) const {
  const auto at = std::lower_bound(ids_.begin(), ids_.end(), id);
  return at != ids_.end() && *at == id ? static_cast<std::uint32_t>(at - ids_.begin()) : kNone;
}

bool Interface::held_by(std::uint32_t i, SubdomainId other) const {
  return std::any_of(others(i).begin(), others(i).end(),
                     [&](const Holder& h) { return h.subdomain == other; });
}

}  // namespace weft::partition
