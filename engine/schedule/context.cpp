// Passes a handler's wishes on to the scheduler, with the handler's object.
#include "engine/schedule/context.h"

#include "engine/schedule/scheduler.h"

namespace weft::engine {

Rank Context::rank() const { return scheduler_.rank(); }
int Context::ranks() const { return scheduler_.ranks(); }
ObjectId Context::self() const { return self_.id; }
int Context::idle_workers() const { return scheduler_.idle_workers(); }
bool Context::stop_requested() const { return scheduler_.stopping(); }
const std::atomic<bool>& Context::stop_flag() const { return scheduler_.stop_flag(); }
const void* Context::local_data() const { return scheduler_.local(); }
const Registry& Context::registry() const { return scheduler_.registry(); }

ObjectId Context::add_object(const TypeInfo& type, void* object) {
  return scheduler_.add_object(type, object);
}

void Context::send(Request request, ObjectId target, std::uint32_t method, std::uint64_t round,
                   Seconds expected, Payload payload) {
  scheduler_.send(self_, request, target, method, round, expected.value, std::move(payload));
}

void Context::declare_event(std::uint32_t method, std::uint64_t round, std::vector<ObjectId> dependencies,
                            Seconds expected) {
  scheduler_.declare_event(self_, method, round, std::move(dependencies), expected.value);
}

}  // namespace weft::engine
