// open, pwrite, fsync, close: with every return code looked at.
#include "meshing/io/files/file_part.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "meshing/base/error.h"

namespace weft::meshing {

FilePart::FilePart(const std::filesystem::path& file, std::string name)
    : name_(std::move(name)), buffer_(std::make_unique_for_overwrite<std::byte[]>(kBufferSize)) {
  do {
    descriptor_ = ::open(file.c_str(), O_WRONLY | O_CLOEXEC);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) fail(errno);
}

FilePart::~FilePart() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void FilePart::flush() {
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
  // On a network file system only this brings what this machine wrote to the one that renames the file.
  if (::fsync(descriptor_) != 0) fail(errno);
  // The descriptor is gone whatever close() returns: it must not be closed twice.
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0) fail(errno);
}

void FilePart::fail(int error) const {
  throw InputError(name_, "", "cannot write: " + std::generic_category().message(error));
}

}  // namespace weft::meshing
