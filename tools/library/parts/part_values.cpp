#include "tools/library/parts/part_values.h"

#include <algorithm>

namespace weft::tools {
namespace {

struct ValueRecord {
  std::uint64_t id;
  double value;
};

}  // namespace

std::vector<double> values_of_slice(partition::Peers& peers, const IdHomes& homes,
                                    const std::vector<std::uint64_t>& ids, std::span<const double> values,
                                    std::string& issue) {
  IdMail<ValueRecord> mail(peers, homes);
  for (std::size_t v = 0; v < values.size(); ++v) mail.add(ids[v], {ids[v], values[v]});
  std::vector<ValueRecord> all;
  for (const auto& of_rank : mail.deliver()) all.insert(all.end(), of_rank.begin(), of_rank.end());
  std::ranges::stable_sort(all, {}, &ValueRecord::id);
  std::vector<double> of_slice;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || all[i].id != all[i - 1].id)
      of_slice.push_back(all[i].value);
    else if (issue.empty() && all[i].value != all[i - 1].value)
      issue = "vertex id " + std::to_string(all[i].id) + ": ranks have different values";
  }
  return of_slice;
}

}  // namespace weft::tools
