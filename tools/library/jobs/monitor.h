// What a caller sees of a run while it lasts, and how it cancels.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "weft/weft.h"

namespace weft::tools {

/// Passes progress to the caller's function, on the calling thread; where that returns false the run is
/// cancelled.
class Monitor {
 public:
  explicit Monitor(const RunOptions& options) : options_(options) {}
  Monitor(const Monitor&) = delete;
  Monitor& operator=(const Monitor&) = delete;

  void update(const std::string& stage, double done, std::uint64_t tets) { tell({stage, false, done, tets}); }
  void tell(const Progress& progress) {
    if (options_.progress && !options_.progress(progress)) flag().store(true);
  }
  /// Set once the run is to end with the mesh that it has: by the caller, or because its function said so.
  std::atomic<bool>& flag() { return options_.cancel ? *options_.cancel : own_; }
  bool cancelled() { return flag().load(); }
  bool wanted() const { return static_cast<bool>(options_.progress); }

 private:
  const RunOptions& options_;
  std::atomic<bool> own_ = false;
};

}  // namespace weft::tools
