// The options that a call is given.
#pragma once

#include <memory>

#include "tools/bindings/c/objects.h"

namespace weft::c {

/// The options of a call while it lasts, NULL being all defaults.
class Asked {
 public:
  explicit Asked(const weft_options* handle) : object_(object_or_none<OptionsObject>(handle, "options")) {}
  const Options& operator*() const { return object_ ? object_->options : defaults_; }
  const Options* operator->() const { return &**this; }

 private:
  std::shared_ptr<OptionsObject> object_;
  Options defaults_;
};

}  // namespace weft::c
