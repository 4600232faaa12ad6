// Immutable pieces that several subdomains of a rank have, once in its memory.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace weft::partition {

/// One copy on a rank of each piece that any of its subdomains has, whichever way it came. Pieces of one `id`
/// are alike. From any thread.
template <class Piece>
class SharedPieces {
 public:
  /// Puts the rank's copies in the place of these. Returns whether any was another one.
  bool share(std::span<std::shared_ptr<const Piece>> pieces) {
    std::vector<std::shared_ptr<const Piece>> replaced;  // may be freed, which is not to be waited for
    const std::lock_guard lock(mutex_);
    for (std::shared_ptr<const Piece>& piece : pieces) {
      std::weak_ptr<const Piece>& known = known_[piece->id];
      std::shared_ptr<const Piece> there = known.lock();
      if (there == piece) continue;
      if (there) {
        replaced.push_back(std::exchange(piece, std::move(there)));
      } else {
        known = piece;
      }
    }
    forget_what_is_gone();
    return !replaced.empty();
  }

  /// Pieces that are known, of which some may be gone.
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return known_.size();
  }

 private:
  using Id = decltype(Piece::id);

  /// Once there are twice as many as were left the last time.
  void forget_what_is_gone() {
    if (known_.size() <= most_) return;
    std::erase_if(known_, [](const auto& known) { return known.second.expired(); });
    most_ = 2 * known_.size() + kFew;
  }

  static constexpr std::size_t kFew = 64;

  mutable std::mutex mutex_;
  std::unordered_map<Id, std::weak_ptr<const Piece>> known_;
  std::size_t most_ = kFew;
};

}  // namespace weft::partition
