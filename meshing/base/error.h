// What is thrown when the user's input cannot be used: names the file, the entity and the reason.
#pragma once

#include <stdexcept>
#include <string>

namespace weft::meshing {

/// Bad input or failed output. what() reads "FILE: ENTITY: REASON" (empty parts left out).
class InputError : public std::runtime_error {
 public:
  InputError(const std::string& file, const std::string& entity, const std::string& reason)
      : std::runtime_error(join(file, join(entity, reason))) {}

 private:
  static std::string join(const std::string& a, const std::string& b) { return a.empty() ? b : a + ": " + b; }
};

}  // namespace weft::meshing
