// open, pwrite, fsync, close: with every return code looked at.
#include "meshing/io/files/file_part.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "meshing/base/error.h"

namespace weft::meshing {

FilePart::FilePart(PartTarget target)
    : target_(std::move(target)), buffer_(std::make_unique_for_overwrite<std::byte[]>(kBufferSize)) {
  if (target_.kept) return;
  do {
    descriptor_ = ::open(target_.file.c_str(), O_WRONLY | O_CLOEXEC);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) fail(errno);
}

FilePart::~FilePart() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void FilePart::keep_buffer() {
  const std::array<std::uint64_t, 2> place{flushed_, used_};
  const auto* head = reinterpret_cast<const std::byte*>(place.data());
  target_.kept->insert(target_.kept->end(), head, head + sizeof place);
  target_.kept->insert(target_.kept->end(), buffer_.get(), buffer_.get() + used_);
  flushed_ += std::exchange(used_, 0);
}

void FilePart::write_kept(const PlacedBytes& kept) {
  for (std::size_t i = 0; i < kept.size();) {
    std::array<std::uint64_t, 2> place;
    std::memcpy(place.data(), &kept[i], sizeof place);
    seek(place[0]);
    write(&kept[i += sizeof place], place[1]);
    i += place[1];
  }
}

void FilePart::flush() {
  if (target_.kept && used_ > 0) return keep_buffer();
  const std::byte* data = buffer_.get();
  while (used_ > 0) {
    const ssize_t written = ::pwrite(descriptor_, data, used_, static_cast<off_t>(flushed_));
    if (written < 0) {
      if (errno == EINTR) continue;
      fail(errno);
    }
    data += written;
    flushed_ += static_cast<std::uint64_t>(written);
    used_ -= static_cast<std::size_t>(written);
  }
}

void FilePart::write(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  while (size > 0) {
    if (used_ == kBufferSize) flush();
    const std::size_t count = std::min(size, kBufferSize - used_);
    std::memcpy(buffer_.get() + used_, bytes, count);
    used_ += count;
    bytes += count;
    size -= count;
  }
}

void FilePart::finish() {
  flush();
  if (target_.kept) return;
  // On a network file system only this brings what this machine wrote to the one that renames the file.
  if (::fsync(descriptor_) != 0) fail(errno);
  // The descriptor is gone whatever close() returns: it must not be closed twice.
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0) fail(errno);
}

void FilePart::fail(int error) const {
  throw InputError(target_.name, "", "cannot write: " + std::generic_category().message(error));
}

}  // namespace weft::meshing
