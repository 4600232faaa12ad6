// Lookup by key (the program's side) and by id (the network's side).
#include "engine/objects/registry.h"

namespace weft::engine {
namespace {

/// FNV-1a. Names travel as their hashes: ranks that run different programs do not call each other's wrong
/// methods.
std::uint32_t hash_of(std::string_view name) {
  std::uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

template <class Map, class Key, class Value>
void insert_once(Map& map, const Key& key, Value value, const std::string& what) {
  if (!map.try_emplace(key, value).second) throw std::logic_error(what + " is registered already");
}

std::uint64_t spread(std::uint64_t value) {
  value = (value + 1) * 0x9E3779B97F4A7C15u;
  return (value ^ value >> 32) * 0xD6E8FEB86659FD93u;
}

}  // namespace

std::uint64_t Registry::fingerprint() const {
  std::uint64_t sum = spread(sizeof(Envelope));  // a sum: the order of registration is no difference
  for (const auto& type : types_) sum += spread(std::uint64_t{type->id} << 1 | (type->movable ? 1 : 0));
  for (const auto& method : methods_) sum += spread(std::uint64_t{1} << 40 | method->id);
  return sum;
}

std::uint32_t Registry::add_type(const void* key, TypeInfo info) {
  info.id = hash_of(info.name);
  auto& stored = types_.emplace_back(std::make_unique<TypeInfo>(std::move(info)));
  insert_once(type_by_id_, stored->id, stored.get(),
              "the type " + stored->name + " (or one with the same hash)");
  insert_once(type_by_key_, key, stored.get(), "the type " + stored->name);
  return stored->id;
}

void Registry::add_method(const void* key, std::uint32_t type, std::string_view name,
                          void (*call)(void*, Context&, Task&)) {
  auto info = std::make_unique<MethodInfo>();
  info->name = type_by_id_.at(type)->name + "::" + std::string(name);
  info->id = hash_of(info->name);
  info->index = static_cast<std::uint32_t>(methods_.size());
  info->type = type;
  info->call = call;
  insert_once(method_by_id_, info->id, info.get(),
              "the method " + info->name + " (or one with the same hash)");
  insert_once(method_by_key_, key, info.get(), "the method " + info->name);
  methods_.push_back(std::move(info));
}

const MethodInfo& Registry::method_of(const void* key) const {
  const auto found = method_by_key_.find(key);
  if (found == method_by_key_.end()) throw std::logic_error("the method called is not registered");
  return *found->second;
}

const TypeInfo& Registry::type_of(const void* key) const {
  const auto found = type_by_key_.find(key);
  if (found == type_by_key_.end()) throw std::logic_error("the type of the mobile object is not registered");
  return *found->second;
}

const MethodInfo* Registry::find_method(std::uint32_t id) const {
  const auto found = method_by_id_.find(id);
  return found == method_by_id_.end() ? nullptr : found->second;
}

const TypeInfo* Registry::find_type(std::uint32_t id) const {
  const auto found = type_by_id_.find(id);
  return found == type_by_id_.end() ? nullptr : found->second;
}

std::vector<std::string> Registry::method_names() const {
  std::vector<std::string> names;
  names.reserve(methods_.size());
  for (const auto& method : methods_) names.push_back(method->name);
  return names;
}

}  // namespace weft::engine
