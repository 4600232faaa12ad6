// What the handles of C stand for, and how calls get at it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "weft/weft-c.h"
#include "weft/weft.h"

namespace weft::c {

/// A call that makes no sense: WEFT_MISUSE.
class Misuse : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Meshes may be members of results and parts, which then live as long as the handle.
struct MeshObject {
  std::shared_ptr<Mesh> mesh;
  /// The mesh, to be changed: a copy where anybody else has it.
  Mesh& own();
};
struct MetricObject {
  std::shared_ptr<const Metric> metric;
};
struct FieldsObject {
  std::shared_ptr<Fields> fields;
  std::shared_ptr<const Transfer> transfer;  ///< that they come from, without values; null: from none
  Fields& own();
};
struct OptionsObject {
  Options options;
  std::atomic<bool> cancel = false;
  std::atomic<bool> checkpoint = false;  ///< one is wanted now
};
struct PartObject {
  std::shared_ptr<Part> part;
};
/// One of the four results; `report` is the base of those of adaptations, and a filling has none.
struct ResultObject {
  std::shared_ptr<Result> whole;
  std::shared_ptr<PartResult> part;
  std::shared_ptr<FilesResult> files;
  std::shared_ptr<FillResult> filled;
  std::mutex mutex;  ///< of the two texts, the measures and what was missed
  std::string summary, json;

  const Report& report() const;
};

struct TextObject {
  std::string text;
};

enum class Kind { mesh, metric, fields, options, part, result, text };
template <class Object>
inline constexpr Kind kKind = Kind::mesh;
template <>
inline constexpr Kind kKind<MetricObject> = Kind::metric;
template <>
inline constexpr Kind kKind<FieldsObject> = Kind::fields;
template <>
inline constexpr Kind kKind<OptionsObject> = Kind::options;
template <>
inline constexpr Kind kKind<PartObject> = Kind::part;
template <>
inline constexpr Kind kKind<ResultObject> = Kind::result;
template <>
inline constexpr Kind kKind<TextObject> = Kind::text;

// A handle is a number that is never used again and that nobody follows, so a freed one, or any other
// pointer, is found out without touching memory. A call holds its objects, so another thread may free the
// handles.
void* add_object(Kind kind, std::shared_ptr<void> object);
std::shared_ptr<void> find_object(Kind kind, const void* handle, const char* argument);
void free_object(const void* handle);
std::int64_t count_objects();

/// The object of a handle; throws Misuse naming the argument.
template <class Object>
std::shared_ptr<Object> object_of(const void* handle, const char* argument) {
  return std::static_pointer_cast<Object>(find_object(kKind<Object>, handle, argument));
}

/// The same where NULL means none.
template <class Object>
std::shared_ptr<Object> object_or_none(const void* handle, const char* argument) {
  return handle ? object_of<Object>(handle, argument) : nullptr;
}

inline std::shared_ptr<Mesh> mesh_of(const weft_mesh* handle, const char* argument = "mesh") {
  return object_of<MeshObject>(handle, argument)->mesh;
}

/// A new handle, which is freed again unless it is given away: where a call gives several things and one of
/// them cannot be made, none is given.
class NewHandle {
 public:
  template <class Object>
  explicit NewHandle(std::shared_ptr<Object> object)
      : handle_(add_object(kKind<Object>, std::move(object))) {}
  ~NewHandle() {
    if (handle_) free_object(handle_);
  }
  NewHandle(const NewHandle&) = delete;
  NewHandle& operator=(const NewHandle&) = delete;

  /// Nothing fails here. `place` may be null: nobody wants it.
  template <class Handle>
  void give(Handle** place) noexcept {
    if (place) *place = static_cast<Handle*>(std::exchange(handle_, nullptr));
  }

 private:
  void* handle_;
};

/// Writes a new handle.
template <class Handle, class Object>
void give(Handle** place, std::shared_ptr<Object> object) {
  NewHandle(std::move(object)).give(place);
}

void give_mesh(weft_mesh** place, std::shared_ptr<Mesh> mesh);
NewHandle new_metric(std::shared_ptr<const Metric> metric);
void give_metric(weft_metric** place, std::shared_ptr<const Metric> metric);
void give_fields(weft_fields** place, std::shared_ptr<Fields> fields,
                 std::shared_ptr<const Transfer> transfer = nullptr);
NewHandle new_text(std::string text);
void give_text(weft_text** place, std::string text);
/// A line each.
NewHandle new_lines(const std::vector<std::string>& lines);

}  // namespace weft::c
