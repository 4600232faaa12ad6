// An array for the scratch of operators, filled without branches.
#pragma once

#include <cstddef>
#include <vector>

namespace weft::meshing {

/// Elements 0 to size() - 1 of storage that is kept: emptying costs nothing, and an element is added or not
/// without a branch, as nobody could predict it.
template <class T>
class FilledArray {
 public:
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t i) const { return storage_[i]; }
  T& operator[](std::size_t i) { return storage_[i]; }
  const T* begin() const { return storage_.data(); }
  const T* end() const { return storage_.data() + size_; }
  void clear() { size_ = 0; }
  /// Room for `count` more.
  void make_room(std::size_t count) {
    if (storage_.size() < size_ + count) grow(count);
  }
  /// Adds `value` where `add` says so; there must be room either way.
  void push_if(bool add, const T& value) {
    storage_[size_] = value;
    size_ += add;
  }

 private:
  [[gnu::noinline]] void grow(std::size_t count) { storage_.resize(2 * (size_ + count)); }

  std::vector<T> storage_;
  std::size_t size_ = 0;
};

}  // namespace weft::meshing
