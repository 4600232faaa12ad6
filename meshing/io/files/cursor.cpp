// The window: what is left of it moves to the front, and a block of the file comes behind.
#include "meshing/io/files/cursor.h"

namespace weft::meshing {
namespace {

constexpr std::uint64_t kBlock = std::uint64_t{1} << 20;

}  // namespace

bool Cursor::read_on(std::size_t& at) {
  const std::size_t given_up = at_, kept = bytes_.size() - at_, ahead = at - at_;
  buffer_.erase(0, buffer_.size() - kept);  // of an empty window the buffer may be another place's
  window_ += given_up;
  const std::uint64_t more = std::min(kBlock, file_size_ - window_ - kept);
  buffer_.resize(kept + more);
  source_->read_at(window_ + kept, buffer_.data() + kept, more);
  bytes_ = buffer_;
  at_ = 0;
  at = ahead;  // may be at_ itself
  return true;
}

bool Cursor::find(std::string_view text) {
  const std::size_t begin = position();
  for (;;) {
    const std::size_t found = bytes_.find(text, at_);
    if (found != std::string_view::npos) {
      at_ = found;
      return true;
    }
    // The text may begin in what is left here.
    if (bytes_.size() - at_ >= text.size()) at_ = bytes_.size() - text.size() + 1;
    std::size_t end = bytes_.size();
    if (!fetch(end)) break;
  }
  seek(begin);
  return false;
}

}  // namespace weft::meshing
