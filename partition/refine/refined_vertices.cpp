// Corners and holders of new vertices, from those of the ends of the edges that they are on.
#include "partition/refine/refined_vertices.h"

#include <algorithm>
#include <iterator>

namespace weft::partition {

RefinedVertices::RefinedVertices(const Interface& interface, std::uint32_t phase)
    : phase_(phase), vertices_(interface.size()), first_new_(interface.size()) {
  for (Index i = 0; i < first_new_; ++i) {
    std::vector<SubdomainId> holders;
    for (const Holder& h : interface.others(i)) holders.push_back(h.subdomain);
    vertices_[i] = {interface.id(i), {i, kNone, kNone}, find_or_add(std::move(holders))};
  }
}

RefinedVertices::Index RefinedVertices::add_between(Index x, Index y) {
  Vertex between;
  between.id = GlobalId::derived_from(id(x), id(y));
  // An earlier phase may have made a vertex of the same edge, which is elsewhere now.
  if (phase_ > 0) between.id = GlobalId::derived_from(between.id, GlobalId::from_value(phase_));
  between.corners = corners(x);
  auto& all = between.corners;
  for (const Index corner : corners(y))
    if (std::find(all.begin(), all.end(), corner) == all.end())
      *std::find(all.begin(), all.end(), kNone) = corner;  // there is room: both ends lie in one face
  between.holders = common(vertices_[x].holders, vertices_[y].holders);
  vertices_.push_back(between);
  return size() - 1;
}

void RefinedVertices::sort_new() {
  std::sort(vertices_.begin() + first_new_, vertices_.end(),
            [](const Vertex& x, const Vertex& y) { return x.id < y.id; });
}

RefinedVertices::Index RefinedVertices::find(GlobalId id) const {
  const auto middle = vertices_.begin() + first_new_;
  const auto find_in = [&](auto begin, auto end) {
    const auto at = std::lower_bound(begin, end, id, [](const Vertex& v, GlobalId x) { return v.id < x; });
    return at != end && at->id == id ? static_cast<Index>(at - vertices_.begin()) : kNone;
  };
  const Index is_new = id.derived() ? find_in(middle, vertices_.end()) : kNone;
  return is_new != kNone ? is_new : find_in(vertices_.begin(), middle);
}

RefinedVertices::SetIndex RefinedVertices::find_or_add(std::vector<SubdomainId> set) {
  const auto [at, is_new] = index_of_set_.try_emplace(std::move(set), static_cast<SetIndex>(sets_.size()));
  if (is_new) sets_.push_back(at->first);
  return at->second;
}

RefinedVertices::SetIndex RefinedVertices::common(SetIndex x, SetIndex y) {
  if (x == y) return x;
  const auto [at, is_new] = common_.try_emplace(std::minmax({x, y}), SetIndex{0});
  if (is_new) {
    std::vector<SubdomainId> both;
    std::ranges::set_intersection(sets_[x], sets_[y], std::back_inserter(both));
    at->second = find_or_add(std::move(both));
  }
  return at->second;
}

}  // namespace weft::partition
