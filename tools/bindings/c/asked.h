// The options that a call is given.
#pragma once

#include <memory>

#include "tools/bindings/c/objects.h"

namespace weft::c {

/// The options of a call while it lasts, NULL being all defaults; a cancel that the caller's function has
/// asked for ends with it.
class Asked {
 public:
  explicit Asked(const weft_options* handle) : object_(object_or_none<OptionsObject>(handle, "options")) {}
  ~Asked() {
    if (object_ && object_->callback_cancelled.exchange(false)) object_->cancel = false;
  }
  Asked(const Asked&) = delete;
  Asked& operator=(const Asked&) = delete;
  const Options& operator*() const { return object_ ? object_->options : defaults_; }
  const Options* operator->() const { return &**this; }

 private:
  std::shared_ptr<OptionsObject> object_;
  Options defaults_;
};

}  // namespace weft::c
