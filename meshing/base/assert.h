// Assertions in four levels, chosen at configuration by WEFT_ASSERTIONS: none; light, in constant time;
// normal, in the time of what is checked around (an operator's cavity); heavy, the whole mesh.
#pragma once

#include <stdexcept>
#include <string>

#ifndef WEFT_ASSERTION_LEVEL
#define WEFT_ASSERTION_LEVEL 0
#endif

namespace weft::meshing {

/// A broken invariant: an error of this program, never of its input.
class AssertionFailed : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline constexpr int kAssertLight = 1, kAssertNormal = 2, kAssertHeavy = 3;
/// For checks that are more than a condition: `if constexpr (asserts(kAssertNormal)) ...`.
static constexpr bool asserts(int level) { return WEFT_ASSERTION_LEVEL >= level; }

[[noreturn]] inline void fail_assertion(const char* condition, const std::string& message, const char* file,
                                        int line) {
  throw AssertionFailed(std::string(file) + ":" + std::to_string(line) + ": " + message + " (" + condition +
                        " does not hold)");
}

}  // namespace weft::meshing

/// The condition is compiled at every level, and evaluated where the level is chosen.
#define WEFT_ASSERT_AT(level, condition, message)                                                   \
  do {                                                                                              \
    if constexpr (::weft::meshing::asserts(level))                                                  \
      if (!(condition)) ::weft::meshing::fail_assertion(#condition, (message), __FILE__, __LINE__); \
  } while (false)

#define WEFT_ASSERT_LIGHT(condition, message) \
  WEFT_ASSERT_AT(::weft::meshing::kAssertLight, condition, message)
#define WEFT_ASSERT_NORMAL(condition, message) \
  WEFT_ASSERT_AT(::weft::meshing::kAssertNormal, condition, message)
#define WEFT_ASSERT_HEAVY(condition, message) \
  WEFT_ASSERT_AT(::weft::meshing::kAssertHeavy, condition, message)
