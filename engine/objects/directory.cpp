// The rules of directory.h.
#include "engine/objects/directory.h"

namespace weft::engine {

Location Directory::best_guess(ObjectId id) const {
  const auto known = known_.find(id);
  return known == known_.end() ? Location{id.home, 0} : known->second;
}

std::optional<Location> Directory::newer(ObjectId id, std::uint32_t age) const {
  const auto known = known_.find(id);
  if (known == known_.end() || known->second.age <= age) return std::nullopt;
  return known->second;
}

void Directory::learn(ObjectId id, Location location) {
  if (destroyed_.contains(id)) return;
  const auto [known, is_new] = known_.try_emplace(id, location);
  if (!is_new && known->second.age < location.age) known->second = location;
}

void Directory::destroyed(ObjectId id) {
  known_.erase(id);
  destroyed_.insert(id);
}

bool Directory::is_gone(ObjectId id, std::uint32_t created) const {
  if (destroyed_.contains(id)) return true;
  // Home has the object, or knows where it went, as long as it lives.
  return id.home == here_ && id.number <= created && !known_.contains(id);
}

}  // namespace weft::engine
