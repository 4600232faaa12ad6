// Packing of arguments and objects into messages, and back.
//
// One function describes both directions:
//
//     struct Part {
//       int round;
//       std::vector<double> values;
//       template <class Archive> void serialize(Archive& archive) { archive(round, values); }
//     };
//
// Bytes are those of the machine: all ranks of a run are alike.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "engine/base/blob.h"

namespace weft::engine {

/// Packed values: small ones one after the other in `bytes`, large arrays as segments.
struct Payload {
  std::vector<std::byte> bytes;
  std::vector<Blob> segments;

  std::size_t size() const {
    std::size_t total = bytes.size();
    for (const Blob& segment : segments) total += segment.size();
    return total;
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(bytes, segments);
  }
};

/// A payload does not hold what the reader expects: it is too short, too long, or has an impossible count.
class UnpackError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Packer;
class Unpacker;

template <class T, class Archive>
concept HasSerialize = requires(std::remove_const_t<T>& value, Archive& archive) {
  value.serialize(archive);
};

/// Types whose bytes may not be copied although C++ allows it: they point elsewhere, consist of parts that
/// may have a serialize(), or have bytes that stand for no value and are undefined behaviour when a damaged
/// message holds them.
template <class T>
inline constexpr bool kIsOpaque =
    std::is_pointer_v<T> || std::is_member_pointer_v<T> || std::is_same_v<T, bool>;
template <class T>
inline constexpr bool kIsOpaque<const T> = kIsOpaque<T>;
template <class T>
inline constexpr bool kIsOpaque<std::optional<T>> = true;
template <class... Ts>
inline constexpr bool kIsOpaque<std::variant<Ts...>> = true;
template <class A, class B>
inline constexpr bool kIsOpaque<std::pair<A, B>> = true;
template <class... Ts>
inline constexpr bool kIsOpaque<std::tuple<Ts...>> = true;
template <class T, std::size_t N>
inline constexpr bool kIsOpaque<std::array<T, N>> = kIsOpaque<T> || HasSerialize<T, Packer>;
template <class T, std::size_t N>
inline constexpr bool kIsOpaque<std::span<T, N>> = true;
template <class C, class Traits>
inline constexpr bool kIsOpaque<std::basic_string_view<C, Traits>> = true;
template <class T>
inline constexpr bool kIsOpaque<std::reference_wrapper<T>> = true;

/// Bytes that may be copied as they are. A type with a serialize() of its own uses that; pointers and views
/// never pass, except inside a struct, where they cannot be seen.
template <class T>
concept PlainData = std::is_trivially_copyable_v<T> && !kIsOpaque<T> && !HasSerialize<T, Packer>;

/// Writes values into a payload. Arrays of plain data of at least kSegmentBytes become segments: moved, not
/// copied, when the packer may consume what it packs (the arguments of a message, an object that leaves).
class Packer {
 public:
  static constexpr bool kPacks = true;
  static constexpr std::size_t kSegmentBytes = 8192;

  /// `consume`: the values packed are not needed afterwards.
  explicit Packer(bool consume = false) : consume_(consume) {}

  template <class... Ts>
  void operator()(Ts&... values) {
    (pack(values), ...);
  }

  /// A segment of its own, whatever its size.
  void blob(Blob blob) { payload_.segments.push_back(std::move(blob)); }

  /// A segment that stays where it is: `owner` keeps it, and nobody changes it.
  void share(std::span<const std::byte> bytes, std::shared_ptr<const void> owner) {
    blob(Blob::share(bytes, std::move(owner)));
  }

  Payload take() { return std::move(payload_); }

 private:
  template <PlainData T>
  void pack(T& value) {
    raw(&value, sizeof(T));
  }
  void pack(const bool& value) { raw(&value, sizeof value); }
  template <class T>
  requires HasSerialize<T, Packer>
  void pack(T& value) {
    // serialize() is written once for both directions, so it cannot be const; what is const is never
    // consumed.
    const bool consume = std::exchange(consume_, consume_ && !std::is_const_v<T>);
    const_cast<std::remove_const_t<T>&>(value).serialize(*this);
    consume_ = consume;
  }
  template <class T, std::size_t N>
  requires(!PlainData<std::array<T, N>>) void pack(std::array<T, N>& values) {
    for (T& value : values) pack(value);
  }
  void pack(Blob& value) { blob(consume_ ? std::move(value) : copy_of(value.data(), value.size())); }
  void pack(std::string& value) {
    count(value.size());
    raw(value.data(), value.size());
  }
  void pack(const std::string& value) { pack(const_cast<std::string&>(value)); }
  template <PlainData T>
  void pack(std::vector<T>& values) {
    const std::size_t bytes = values.size() * sizeof(T);
    if (bytes < kSegmentBytes) room_for(sizeof(std::uint64_t) + bytes);
    count(values.size());
    if (bytes < kSegmentBytes) {
      raw(values.data(), bytes);
    } else if (consume_) {
      blob(Blob::adopt(std::move(values)));
    } else {
      blob(copy_of(values.data(), bytes));
    }
  }
  template <class T>
  void pack(std::vector<T>& values) {
    count(values.size());
    for (auto&& value : values) {
      std::conditional_t<std::is_same_v<T, bool>, bool, T&> element = value;
      pack(element);
    }
  }
  template <class T>
  void pack(std::optional<T>& value) {
    const bool present = value.has_value();
    pack(present);
    if (value) pack(*value);
  }
  template <class T>
  void pack(std::unique_ptr<T>& value) {
    const bool present = value != nullptr;
    pack(present);
    if (value) pack(*value);
  }
  template <class A, class B>
  void pack(std::pair<A, B>& value) {
    pack(const_cast<std::remove_const_t<A>&>(value.first));
    pack(value.second);
  }
  template <class... Ts>
  void pack(std::tuple<Ts...>& value) {
    std::apply([&](auto&... parts) { (this->pack(parts), ...); }, value);
  }
  template <class... Ts>
  void pack(std::variant<Ts...>& value) {
    auto index = static_cast<std::uint32_t>(value.index());
    pack(index);
    std::visit([&](auto& held) { this->pack(held); }, value);
  }
  template <class Range>
  void pack_range(Range& range) {
    count(range.size());
    for (auto& element : range) pack(const_cast<typename Range::value_type&>(element));
  }
  template <class K, class V, class C>
  void pack(std::map<K, V, C>& values) {
    pack_range(values);
  }
  template <class K, class C>
  void pack(std::set<K, C>& values) {
    pack_range(values);
  }
  template <class K, class V, class H>
  void pack(std::unordered_map<K, V, H>& values) {
    pack_range(values);
  }

  static Blob copy_of(const void* data, std::size_t size) {
    Blob copy = Blob::allocate(size);
    if (size > 0) std::memcpy(copy.data(), data, size);
    return copy;
  }
  /// With some more, so that the arguments of most messages are in one allocation.
  void room_for(std::size_t size) {
    constexpr std::size_t kMore = 96;
    const std::size_t wanted = payload_.bytes.size() + size, room = payload_.bytes.capacity();
    if (wanted > room) payload_.bytes.reserve(std::max(2 * room, wanted + kMore));
  }
  void count(std::size_t n) {
    const std::uint64_t value = n;
    raw(&value, sizeof value);
  }
  void raw(const void* data, std::size_t size) {
    room_for(size);
    const auto* first = static_cast<const std::byte*>(data);
    payload_.bytes.insert(payload_.bytes.end(), first, first + size);
  }

  bool consume_;
  Payload payload_;
};

/// Reads values out of a payload, in the order in which they were written. Throws UnpackError at whatever
/// does not fit: counts are compared with the bytes that are left before anything is allocated.
class Unpacker {
 public:
  static constexpr bool kPacks = false;

  explicit Unpacker(Payload payload) : payload_(std::move(payload)) {}

  template <class... Ts>
  void operator()(Ts&... values) {
    (unpack(values), ...);
  }

  Blob blob() {
    if (segment_ == payload_.segments.size()) throw UnpackError("a large array is missing");
    return std::move(payload_.segments[segment_++]);
  }

  /// A segment, and who keeps it: within a process that of Packer::share().
  std::pair<std::span<const std::byte>, std::shared_ptr<const void>> shared() {
    auto segment = std::make_shared<const Blob>(blob());
    const auto bytes = segment->bytes();
    return {bytes, std::move(segment)};
  }

  /// Throws UnpackError unless everything has been read.
  void finish() const {
    if (next_ != payload_.bytes.size() || segment_ != payload_.segments.size()) {
      throw UnpackError("there is more in the message than was read (" +
                        std::to_string(payload_.bytes.size() - next_) + " bytes, " +
                        std::to_string(payload_.segments.size() - segment_) + " large arrays)");
    }
  }

 private:
  template <PlainData T>
  void unpack(T& value) {
    raw(&value, sizeof(T));
  }
  void unpack(bool& value) { value = flag(); }
  template <class T>
  requires HasSerialize<T, Unpacker>
  void unpack(T& value) { value.serialize(*this); }
  template <class T, std::size_t N>
  requires(!PlainData<std::array<T, N>>) void unpack(std::array<T, N>& values) {
    for (T& value : values) unpack(value);
  }
  void unpack(Blob& value) { value = blob(); }
  void unpack(std::string& value) {
    value.resize(count(1));
    raw(value.data(), value.size());
  }
  template <PlainData T>
  void unpack(std::vector<T>& values) {
    std::uint64_t n = 0;
    raw(&n, sizeof n);
    if (n > std::uint64_t(-1) / sizeof(T)) throw UnpackError("an array has an impossible length");
    const std::uint64_t bytes = n * sizeof(T);
    if (bytes < Packer::kSegmentBytes) {
      require(bytes);
      values.resize(n);
      raw(values.data(), bytes);
    } else {
      const Blob segment = blob();
      if (segment.size() != bytes) {
        throw UnpackError("a large array has " + std::to_string(segment.size()) + " bytes instead of " +
                          std::to_string(bytes));
      }
      const auto* first = reinterpret_cast<const T*>(segment.data());
      values.assign(first, first + n);
    }
  }
  template <class T>
  void unpack(std::vector<T>& values) {
    static_assert(!std::is_empty_v<T>, "a count of elements without bytes cannot be checked");
    const std::size_t n = count(1);
    values.clear();
    for (std::size_t i = 0; i < n; ++i) {
      T value{};
      unpack(value);
      values.push_back(std::move(value));
    }
  }
  template <class T>
  void unpack(std::optional<T>& value) {
    value.reset();
    if (flag()) unpack(value.emplace());
  }
  template <class T>
  void unpack(std::unique_ptr<T>& value) {
    value.reset();
    if (flag()) {
      value = std::make_unique<T>();
      unpack(*value);
    }
  }
  template <class A, class B>
  void unpack(std::pair<A, B>& value) {
    unpack(value.first);
    unpack(value.second);
  }
  template <class... Ts>
  void unpack(std::tuple<Ts...>& value) {
    std::apply([&](auto&... parts) { (this->unpack(parts), ...); }, value);
  }
  template <class... Ts>
  void unpack(std::variant<Ts...>& value) {
    std::uint32_t index = 0;
    unpack(index);
    if (index >= sizeof...(Ts)) throw UnpackError("a variant holds none of its alternatives");
    std::uint32_t i = 0;
    ((i++ == index ? unpack(value.template emplace<Ts>()) : void()), ...);
  }
  template <class K, class V, class C>
  void unpack(std::map<K, V, C>& values) {
    unpack_range<std::pair<K, V>>(values);
  }
  template <class K, class C>
  void unpack(std::set<K, C>& values) {
    unpack_range<K>(values);
  }
  template <class K, class V, class H>
  void unpack(std::unordered_map<K, V, H>& values) {
    unpack_range<std::pair<K, V>>(values);
  }
  template <class Element, class Range>
  void unpack_range(Range& range) {
    const std::size_t n = count(1);
    range.clear();
    for (std::size_t i = 0; i < n; ++i) {
      Element element{};
      unpack(element);
      range.insert(std::move(element));
    }
  }

  bool flag() {
    std::uint8_t value = 0;
    raw(&value, 1);
    if (value > 1) throw UnpackError("a flag is neither 0 nor 1");
    return value == 1;
  }
  /// A count of elements that take at least `least` bytes each.
  std::size_t count(std::size_t least) {
    std::uint64_t n = 0;
    raw(&n, sizeof n);
    const std::size_t left = payload_.bytes.size() - next_ + payload_.segments.size() - segment_;
    if (least > 0 && n > left / least) throw UnpackError("a count is larger than its message");
    return n;
  }
  void require(std::uint64_t size) const {
    if (size > payload_.bytes.size() - next_) {
      throw UnpackError("the message ends " + std::to_string(size - (payload_.bytes.size() - next_)) +
                        " bytes too soon");
    }
  }
  void raw(void* to, std::size_t size) {
    require(size);
    if (size > 0) std::memcpy(to, payload_.bytes.data() + next_, size);
    next_ += size;
  }

  Payload payload_;
  std::size_t next_ = 0;
  std::size_t segment_ = 0;
};

/// A value as a payload, and back. The value is consumed.
template <class T>
Payload packed(T value) {
  Packer packer(true);
  packer(value);
  return packer.take();
}

template <class T>
T unpacked(Payload payload) {
  T value{};
  Unpacker unpacker(std::move(payload));
  unpacker(value);
  unpacker.finish();
  return value;
}

}  // namespace weft::engine
