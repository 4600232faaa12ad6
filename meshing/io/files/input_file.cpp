// open, fstat and pread, with every return code looked at.
#include "meshing/io/files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "meshing/base/error.h"

namespace weft::meshing {

InputFile::InputFile(const std::filesystem::path& path) : name_(path.string()) {
  // O_NONBLOCK: opening a pipe by mistake must not hang.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) fail_read(errno);
  struct stat info {};
  const bool known = ::fstat(descriptor_, &info) == 0;
  if (!known || !S_ISREG(info.st_mode)) {
    ::close(descriptor_);
    throw InputError(name_, "", "cannot read: not a regular file");
  }
  size_ = static_cast<std::uint64_t>(info.st_size);
}

InputFile::~InputFile() { ::close(descriptor_); }

void InputFile::read_at(std::uint64_t position, void* out, std::uint64_t size) const {
  auto* bytes = static_cast<std::byte*>(out);
  while (size > 0) {
    const ssize_t got = ::pread(descriptor_, bytes, size, static_cast<off_t>(position));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_read(errno);
    if (got == 0) throw InputError(name_, "", "the file became shorter while it was read");
    bytes += got;
    position += static_cast<std::uint64_t>(got);
    size -= static_cast<std::uint64_t>(got);
  }
}

void InputFile::fail_read(int error) const {
  throw InputError(name_, "", "cannot read: " + std::generic_category().message(error));
}

FileBytes::FileBytes(const std::filesystem::path& path) {
  const InputFile file(path);
  name_ = file.name();
  size_ = file.size();
  bytes_ = std::make_unique_for_overwrite<char[]>(size_);
  file.read_at(0, bytes_.get(), size_);
}

}  // namespace weft::meshing
