// Temporary file, fsync, rename: with every return code looked at, since disks do fill up.
#include "meshing/io/files/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <string>
#include <system_error>

#include "meshing/base/error.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

/// A short name, whatever the target's: a long name with a suffix could exceed the file system's limit.
fs::path temporary_beside(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  return target.parent_path() /
         (".weft-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
}

/// Where the data must go: renaming over a symbolic link would replace the link instead of the file it names.
fs::path resolve(const fs::path& target) {
  std::error_code error;
  if (!fs::is_symlink(target, error)) return target;
  const fs::path real = fs::canonical(target, error);
  return error ? target : real;
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& target)
    : target_(target),
      resolved_(resolve(target)),
      buffer_(std::make_unique_for_overwrite<std::byte[]>(kBufferSize)) {
  // Renaming over a device would replace it; over a directory it would fail only after all the work.
  std::error_code ignored;
  const fs::file_status status = fs::status(resolved_, ignored);
  if (ignored == std::errc::filename_too_long) fail(ENAMETOOLONG);
  if (fs::is_directory(status)) fail(EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw InputError(target_.string(), "", "cannot write: not a regular file");
  }
  do {
    temporary_ = temporary_beside(resolved_);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && (errno == EEXIST || errno == EINTR));
  if (descriptor_ < 0) fail(errno);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::commit() {
  flush();
  if (::fsync(descriptor_) != 0) fail(errno);
  // The descriptor is gone whatever close() returns: it must not be closed twice.
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) fail(errno);
  if (::rename(temporary_.c_str(), resolved_.c_str()) != 0) fail(errno);
  temporary_.clear();
}

void AtomicFile::write_large(const void* data, std::size_t size) {
  flush();
  if (size > kBufferSize) {
    write_through(static_cast<const std::byte*>(data), size);
  } else {
    std::memcpy(buffer_.get(), data, size);
    used_ = size;
  }
}

void AtomicFile::flush() {
  write_through(buffer_.get(), used_);
  used_ = 0;
}

void AtomicFile::write_through(const std::byte* data, std::size_t size) {
  flushed_ += size;
  while (size > 0) {
    const ssize_t written = ::write(descriptor_, data, size);
    if (written < 0) {
      if (errno == EINTR) continue;
      fail(errno);
    }
    data += written;
    size -= static_cast<std::size_t>(written);
  }
}

void AtomicFile::fail(int error) const {
  throw InputError(target_.string(), "", "cannot write: " + std::generic_category().message(error));
}

FormerFile::FormerFile(const fs::path& target)
    : target_(resolve(target)), is_new_(!fs::exists(target_)), exceptions_(std::uncaught_exceptions()) {
  if (is_new_) return;
  link_ = temporary_beside(target_);
  std::error_code error;
  fs::create_hard_link(target_, link_, error);
  if (error) link_.clear();
}

FormerFile::~FormerFile() {
  const bool failed = std::uncaught_exceptions() > exceptions_;
  std::error_code ignored;
  if (failed && is_new_) fs::remove(target_, ignored);
  if (link_.empty()) return;
  if (failed) fs::rename(link_, target_, ignored);
  fs::remove(link_, ignored);  // still there where it was renamed to another name of itself
}

}  // namespace weft::meshing
