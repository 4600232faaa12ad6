// Memory that runs out at a chosen allocation.
#pragma once

namespace weft::testing {

#if defined(__SANITIZE_ADDRESS__)  // which has an allocator of its own
inline constexpr bool kNewCanFail = false;
#else
inline constexpr bool kNewCanFail = true;
#endif

/// While it lives one call of `new` on this thread throws std::bad_alloc, after so many that succeed. One at
/// a time.
class FailingNew {
 public:
  explicit FailingNew(int successes) { left_ = successes; }
  ~FailingNew() { left_ = -1; }
  FailingNew(const FailingNew&) = delete;
  FailingNew& operator=(const FailingNew&) = delete;

  bool has_failed() const { return left_ < 0; }
  int successes_left() const { return left_; }

  /// Called by `new`: whether this is the one.
  static bool fails() { return left_ >= 0 && left_-- == 0; }

 private:
  static thread_local int left_;
};

}  // namespace weft::testing
