// All ranks join all components, of which there are few.
#include "partition/surface/joined_patches.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "meshing/base/sort_unique.h"

namespace weft::partition {
namespace {

/// Disjoint sets whose members are turned or not against their root.
class TurnedSets {
 public:
  explicit TurnedSets(std::size_t count) : parent_(count), turned_(count, 0), size_(count, 1) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  /// The root, and 1 where `i` is turned against it. No chain is longer than the logarithm of its set.
  std::pair<std::uint32_t, std::uint8_t> root(std::uint32_t i) const {
    std::uint8_t turned = 0;
    for (; parent_[i] != i; i = parent_[i]) turned = static_cast<std::uint8_t>(turned ^ turned_[i]);
    return {i, turned};
  }
  /// False where they are in one set and do not agree.
  bool join(const ComponentLink& link) {
    const auto [a, turned_a] = root(link.a);
    const auto [b, turned_b] = root(link.b);
    const auto turned = static_cast<std::uint8_t>(turned_a ^ turned_b ^ link.turned);
    if (a == b) return turned == 0;
    const auto [small, large] = size_[a] < size_[b] ? std::pair{a, b} : std::pair{b, a};
    parent_[small] = large;
    turned_[small] = turned;
    size_[large] += size_[small];
    return true;
  }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint8_t> turned_;
  std::vector<std::uint32_t> size_;
};

/// `one_sided`: components that do not agree with themselves or with others of their sets.
JoinedPatches patches_of(const std::vector<PatchComponent>& components, const TurnedSets& sets,
                         const std::vector<std::uint8_t>& one_sided) {
  // A patch is named by its first triangle, and so is its component.
  std::vector<std::uint32_t> first(components.size());
  std::iota(first.begin(), first.end(), 0u);
  for (std::uint32_t c = 0; c < components.size(); ++c) {
    std::uint32_t& of_set = first[sets.root(c).first];
    if (components[c].first < components[of_set].first) of_set = c;
  }
  std::vector<std::uint32_t> names;
  for (std::uint32_t c = 0; c < components.size(); ++c)
    if (first[sets.root(c).first] == c) names.push_back(c);
  std::ranges::sort(names, {}, [&](std::uint32_t c) { return components[c].first; });
  JoinedPatches joined;
  std::vector<std::uint32_t> patch_of_set(components.size());
  for (const std::uint32_t c : names) {
    patch_of_set[sets.root(c).first] = static_cast<std::uint32_t>(joined.refs.size());
    joined.refs.push_back(components[c].ref);
    joined.firsts.push_back(components[c].first);
  }
  joined.one_sided.assign(names.size(), 0);
  std::vector<std::uint64_t> turned(names.size(), 0), triangles(names.size(), 0);
  for (std::uint32_t c = 0; c < components.size(); ++c) {
    const auto [root, against_root] = sets.root(c);
    joined.patch.push_back(patch_of_set[root]);
    joined.one_sided[joined.patch[c]] |= one_sided[c];
    joined.turned.push_back(static_cast<std::uint8_t>(against_root ^ sets.root(first[root]).second));
    triangles[joined.patch[c]] += components[c].triangles;
    turned[joined.patch[c]] +=
        joined.turned[c] ? components[c].triangles - components[c].turned : components[c].turned;
  }
  for (std::uint32_t c = 0; c < components.size(); ++c)
    if (2 * turned[joined.patch[c]] > triangles[joined.patch[c]]) joined.turned[c] ^= 1;
  return joined;
}

}  // namespace

JoinedPatches join_patches(Peers& peers, const std::vector<PatchComponent>& mine,
                           const std::vector<ComponentLink>& links) {
  const std::vector<PatchComponent> components = allgather_joined(peers, mine);
  std::vector<ComponentLink> all = links;
  meshing::sort_unique(all);
  all = allgather_joined(peers, all);
  TurnedSets sets(components.size());
  std::vector<std::uint8_t> one_sided;
  for (const PatchComponent& c : components) one_sided.push_back(c.one_sided != 0);
  for (const ComponentLink& link : all)
    if (!sets.join(link)) one_sided[link.a] = 1;
  return patches_of(components, sets, one_sided);
}

}  // namespace weft::partition
