/// nlohmann's documents, to be included as this header: their destructor takes no memory here. nlohmann's own
/// takes some, to have deep documents without recursion, and must not throw: one failed allocation would end
/// the process.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

template <>
inline void nlohmann::ordered_json::json_value::destroy(value_t type);

namespace weft::engine {

/// The last value in an array or object; nullptr where there is none.
inline nlohmann::ordered_json* last_in(nlohmann::ordered_json& json) noexcept {
  if (auto* array = json.get_ptr<nlohmann::ordered_json::array_t*>())
    return array->empty() ? nullptr : &array->back();
  if (auto* object = json.get_ptr<nlohmann::ordered_json::object_t*>())
    return object->empty() ? nullptr : &object->back().second;
  return nullptr;
}

/// Destroys what last_in() names.
inline void drop_last(nlohmann::ordered_json& json) noexcept {
  if (auto* array = json.get_ptr<nlohmann::ordered_json::array_t*>()) return array->pop_back();
  json.get_ptr<nlohmann::ordered_json::object_t*>()->pop_back();
}

/// Leaves an empty array or object, or a value that is neither. The way back up is kept in the last places of
/// the arrays and objects that it has gone down into.
inline void make_empty(nlohmann::ordered_json& json) noexcept {
  nlohmann::ordered_json above;
  for (;;) {
    nlohmann::ordered_json* last = last_in(json);
    if (last == nullptr && above.is_null()) return;
    if (last == nullptr) {
      json = std::move(above);
      above = std::move(*last_in(json));
      drop_last(json);
    } else if (last_in(*last) == nullptr) {
      drop_last(json);
    } else {
      nlohmann::ordered_json below = std::move(*last);
      *last = std::move(above);
      above = std::move(json);
      json = std::move(below);
    }
  }
}

}  // namespace weft::engine

/// An array or object that could not be made is null.
template <>
inline void nlohmann::ordered_json::json_value::destroy(value_t type) {
  if (type == value_t::array && array != nullptr)
    for (; !array->empty(); array->pop_back()) weft::engine::make_empty(array->back());
  if (type == value_t::object && object != nullptr)
    for (; !object->empty(); object->pop_back()) weft::engine::make_empty(object->back().second);
  if (type == value_t::array) delete array;
  if (type == value_t::object) delete object;
  if (type == value_t::string) delete string;
  if (type == value_t::binary) delete binary;
}

namespace weft::engine {

/// The document's "schema"; empty where it has none that is text.
inline std::string schema_of(const nlohmann::ordered_json& document) {
  if (!document.is_object()) return {};
  const auto found = document.find("schema");
  return found != document.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace weft::engine
