// The frame of every function: exceptions become a status and a text; what arguments must be.
#pragma once

#include <cstdint>
#include <exception>
#include <string>

#include "tools/bindings/c/objects.h"

namespace weft::c {

/// What an exception means in C; its text goes to `text`.
weft_status status_of(const std::exception_ptr& error, std::string& text);
/// The text that weft_last_error() gives.
void set_last_error(const std::string& text) noexcept;
/// Remembers what the exception says, and returns its status.
weft_status fail_with(const std::exception_ptr& error) noexcept;

/// Runs call(); nothing leaves but a status.
template <class Call>
weft_status guarded(const Call& call) noexcept {
  try {
    call();
    return WEFT_OK;
  } catch (...) {
    return fail_with(std::current_exception());
  }
}

void require(bool good, const std::string& misuse);
/// An array of `count` rows of `width` numbers that the caller reads or writes.
void require_array(const void* array, std::int64_t count, std::int64_t width, const char* argument);
void require_place(const void* place, const char* argument);
std::string require_text(const char* text, const char* argument);
std::string text_or_none(const char* text);  ///< NULL: none
/// Three finite numbers.
Point point_of(const double* x, const char* argument);

}  // namespace weft::c
