// The register of handles.
#include "tools/bindings/c/objects.h"

#include <unordered_map>
#include <utility>

namespace weft::c {
namespace {

struct Entry {
  Kind kind;
  std::shared_ptr<void> object;
};

class Register {
 public:
  void* add(Kind kind, std::shared_ptr<void> object) {
    const std::lock_guard lock(mutex_);
    next_ += kStep;
    entries_.emplace(next_, Entry{kind, std::move(object)});
    return reinterpret_cast<void*>(next_);  // never followed: NOLINT(performance-no-int-to-ptr)
  }

  Entry find(const void* handle) {
    const std::lock_guard lock(mutex_);
    const auto at = entries_.find(reinterpret_cast<std::uintptr_t>(handle));
    return at == entries_.end() ? Entry{} : at->second;
  }

  bool remove(const void* handle) {
    Entry last;  // outlives the lock: what it holds may be large
    const std::lock_guard lock(mutex_);
    const auto at = entries_.find(reinterpret_cast<std::uintptr_t>(handle));
    if (at == entries_.end()) return false;
    last = std::move(at->second);
    entries_.erase(at);
    return true;
  }

  std::int64_t size() {
    const std::lock_guard lock(mutex_);
    return static_cast<std::int64_t>(entries_.size());
  }

 private:
  static constexpr std::uintptr_t kStep = 16;
  std::mutex mutex_;
  std::uintptr_t next_ = 0;
  std::unordered_map<std::uintptr_t, Entry> entries_;
};

/// Lives until the process ends: programs may free handles in destructors of static objects.
Register& all() {
  static auto* objects = new Register;
  return *objects;
}

const char* name_of(Kind kind) {
  constexpr const char* kNames[] = {"weft_mesh", "weft_metric", "weft_fields", "weft_options",
                                    "weft_part", "weft_result", "weft_text"};
  return kNames[static_cast<int>(kind)];
}

}  // namespace

void* add_object(Kind kind, std::shared_ptr<void> object) { return all().add(kind, std::move(object)); }

std::shared_ptr<void> find_object(Kind kind, const void* handle, const char* argument) {
  if (!handle) throw Misuse(std::string(argument) + ": is NULL, not a " + name_of(kind));
  Entry entry = all().find(handle);
  if (!entry.object)
    throw Misuse(std::string(argument) + ": is no handle of weft, or has been freed; a " + name_of(kind) +
                 " is wanted");
  if (entry.kind != kind)
    throw Misuse(std::string(argument) + ": is a " + name_of(entry.kind) + ", not a " + name_of(kind));
  return std::move(entry.object);
}

void free_object(const void* handle) {
  if (handle && !all().remove(handle)) throw Misuse("handle: is none of weft, or has been freed before");
}

std::int64_t count_objects() { return all().size(); }

Mesh& MeshObject::own() {
  if (mesh.use_count() > 1) mesh = std::make_shared<Mesh>(*mesh);
  return *mesh;
}

Fields& FieldsObject::own() {
  if (fields.use_count() > 1) fields = std::make_shared<Fields>(*fields);
  return *fields;
}

const Report& ResultObject::report() const {
  if (whole) return *whole;
  if (part) return *part;
  if (files) return *files;
  throw Misuse("result: is one of weft_fill_to_result(), of which there is no report");
}

void give_mesh(weft_mesh** place, std::shared_ptr<Mesh> mesh) {
  auto object = std::make_shared<MeshObject>();
  object->mesh = std::move(mesh);
  give(place, std::move(object));
}

NewHandle new_metric(std::shared_ptr<const Metric> metric) {
  auto object = std::make_shared<MetricObject>();
  object->metric = std::move(metric);
  return NewHandle(std::move(object));
}

void give_metric(weft_metric** place, std::shared_ptr<const Metric> metric) {
  new_metric(std::move(metric)).give(place);
}

NewHandle new_text(std::string text) {
  auto object = std::make_shared<TextObject>();
  object->text = std::move(text);
  return NewHandle(std::move(object));
}

void give_text(weft_text** place, std::string text) { new_text(std::move(text)).give(place); }

NewHandle new_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return new_text(std::move(text));
}

void give_fields(weft_fields** place, std::shared_ptr<Fields> fields,
                 std::shared_ptr<const Transfer> transfer) {
  auto object = std::make_shared<FieldsObject>();
  object->fields = std::move(fields);
  object->transfer = std::move(transfer);
  give(place, std::move(object));
}

}  // namespace weft::c
