// Numbers as text that JavaScript turns back into typed arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace weft::report {

/// RFC 4648, with padding.
std::string base64(std::span<const std::byte> bytes);

/// An array as it lies in memory (little endian on every machine that weft runs on).
template <class T>
std::string base64_of(const T& array) {
  return base64(std::as_bytes(std::span(array)));
}

}  // namespace weft::report
