#include "tools/bindings/c/calls.h"

#include <algorithm>
#include <cmath>
#include <new>

namespace weft::c {
namespace {

std::string& last_error() {
  thread_local std::string text;
  return text;
}

}  // namespace

weft_status status_of(const std::exception_ptr& error, std::string& text) {
  try {
    std::rethrow_exception(error);
  } catch (const Misuse& e) {
    text = e.what();
    return WEFT_MISUSE;
  } catch (const InputError& e) {
    text = e.what();
    return WEFT_INPUT_ERROR;
  } catch (const OptionError& e) {
    text = e.what();
    return WEFT_OPTION_ERROR;
  } catch (const RunError& e) {
    text = e.what();
    return WEFT_RUN_ERROR;
  } catch (const std::bad_alloc&) {
    text = "out of memory";
    return WEFT_OUT_OF_MEMORY;
  } catch (const std::length_error&) {
    text = "out of memory: larger than any array can be";
    return WEFT_OUT_OF_MEMORY;
  } catch (const std::exception& e) {
    text = e.what();
  } catch (...) {
    text = "unknown error";
  }
  return WEFT_INTERNAL_ERROR;
}

void set_last_error(const std::string& text) noexcept {
  try {
    last_error() = text;
  } catch (...) {  // no memory for the text: the status still says it
  }
}

weft_status fail_with(const std::exception_ptr& error) noexcept {
  try {
    std::string text;
    const weft_status status = status_of(error, text);
    set_last_error(text);
    return status;
  } catch (...) {
    return WEFT_OUT_OF_MEMORY;
  }
}

void require(bool good, const std::string& misuse) {
  if (!good) throw Misuse(misuse);
}

void require_array(const void* array, std::int64_t count, std::int64_t width, const char* argument) {
  constexpr std::int64_t kMost = std::int64_t{1} << 56;
  require(count >= 0, std::string(argument) + ": " + std::to_string(count) + " rows are fewer than none");
  require(count <= kMost / std::max<std::int64_t>(width, 1),
          std::string(argument) + ": " + std::to_string(count) + " rows are more than memory can have");
  require(array || count == 0,
          std::string(argument) + ": is NULL, not an array of " + std::to_string(count) + " rows");
}

void require_place(const void* place, const char* argument) {
  require(place, std::string(argument) + ": is NULL, and the result has no place to go to");
}

std::string require_text(const char* text, const char* argument) {
  require(text, std::string(argument) + ": is NULL, not a text");
  return text;
}

std::string text_or_none(const char* text) { return text ? text : ""; }

Point point_of(const double* x, const char* argument) {
  require(x, std::string(argument) + ": is NULL, not x y z");
  for (int i = 0; i < 3; ++i)
    require(std::isfinite(x[i]), std::string(argument) + "[" + std::to_string(i) + "]: is not finite");
  return {x[0], x[1], x[2]};
}

}  // namespace weft::c

extern "C" {

const char* weft_version(void) { return weft::version(); }

const char* weft_last_error(void) { return weft::c::last_error().c_str(); }

weft_status weft_refuse(const char* why) {
  return guarded([&] { throw weft::c::Misuse(require_text(why, "why")); });
}

const char* weft_status_name(weft_status status) {
  switch (status) {
    case WEFT_OK:
      return "ok";
    case WEFT_MISUSE:
      return "misuse";
    case WEFT_INPUT_ERROR:
      return "input error";
    case WEFT_OPTION_ERROR:
      return "option error";
    case WEFT_RUN_ERROR:
      return "run error";
    case WEFT_OUT_OF_MEMORY:
      return "out of memory";
    case WEFT_INTERNAL_ERROR:
      return "internal error";
  }
  return "unknown status";
}

weft_status weft_free(void* handle) {
  return weft::c::guarded([&] { weft::c::free_object(handle); });
}

int64_t weft_handles(void) {
  try {
    return weft::c::count_objects();
  } catch (...) {
    return -1;
  }
}

}  // extern "C"
