// A large block of bytes with one owner, passed from a handler to the network and back without being copied.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace weft::engine {

/// Move-only bytes that keep alive whatever holds them: a block of their own, an adopted vector, part of an
/// object.
class Blob {
 public:
  Blob() = default;
  Blob(Blob&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        holder_(std::move(other.holder_)) {}
  Blob& operator=(Blob&& other) noexcept {
    data_ = std::exchange(other.data_, nullptr);
    size_ = std::exchange(other.size_, 0);
    holder_ = std::move(other.holder_);
    return *this;
  }

  /// `size` bytes, aligned to a cache line, not initialised; freed blocks are kept for the next request
  /// (receiving a large message into fresh pages costs as much as the message). Throws std::bad_alloc.
  static Blob allocate(std::size_t size);

  /// The elements of `values`, which move into the blob.
  template <class T>
  static Blob adopt(std::vector<T>&& values) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_same_v<T, bool>);
    auto holder = std::make_unique<std::vector<T>>(std::move(values));
    Blob blob;
    blob.data_ = reinterpret_cast<std::byte*>(holder->data());
    blob.size_ = holder->size() * sizeof(T);
    blob.holder_ = Holder(holder.release(), [](void* p) { delete static_cast<std::vector<T>*>(p); });
    return blob;
  }

  /// `bytes`, which stay where they are; `owner` is kept until the blob goes.
  static Blob share(std::span<const std::byte> bytes, std::shared_ptr<const void> owner) {
    using Owner = std::shared_ptr<const void>;
    Blob blob;
    blob.data_ = const_cast<std::byte*>(bytes.data());
    blob.size_ = bytes.size();
    blob.holder_ = Holder(new Owner(std::move(owner)), [](void* p) { delete static_cast<Owner*>(p); });
    return blob;
  }

  std::byte* data() { return data_; }
  const std::byte* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  using Holder = std::unique_ptr<void, void (*)(void*)>;

  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
  Holder holder_{nullptr, [](void*) {}};
};

}  // namespace weft::engine
