// Immutable pieces that several subdomains of a rank have, once in its memory.
#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>

namespace weft::partition {

/// One copy on a rank of each piece that any of its subdomains has, whichever way it came. Pieces of one `id`
/// are alike. From any thread.
template <class Piece>
class SharedPieces {
 public:
  /// Puts the rank's copies in the place of these. Returns whether any was another one.
  bool share(std::span<std::shared_ptr<const Piece>> pieces) {
    bool any = false;
    const std::lock_guard lock(mutex_);
    for (std::shared_ptr<const Piece>& piece : pieces) {
      std::weak_ptr<const Piece>& known = known_[piece->id];
      std::shared_ptr<const Piece> there = known.lock();
      if (there == piece) continue;
      if (there) {
        piece = std::move(there);
        any = true;
      } else {
        known = piece;
      }
    }
    return any;
  }

 private:
  using Id = decltype(Piece::id);

  std::mutex mutex_;
  std::unordered_map<Id, std::weak_ptr<const Piece>> known_;
};

}  // namespace weft::partition
