// What reading and writing of CGNS files share: the CGNS library with a file open, and words of weft's files.
#pragma once

#include <cgnslib.h>
#include <hdf5.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "meshing/base/error.h"

namespace weft::meshing::cgns {

inline constexpr std::size_t kNameLength = 32;
using Name = std::array<char, kNameLength + 1>;

inline constexpr std::string_view kTetPrefix = "tets_", kEdgePrefix = "edges_";
inline constexpr std::array<const char*, 3> kCoordinates = {"CoordinateX", "CoordinateY", "CoordinateZ"};
inline constexpr std::array<const char*, 3> kVectorEnds = {"X", "Y", "Z"};
inline constexpr std::array<const char*, 6> kTensorEnds = {"XX", "XY", "YY", "XZ", "YZ", "ZZ"};

/// The library has one state for all threads.
inline std::mutex& library_mutex() {
  // What a damaged file leaves behind would make HDF5 complain on stderr at the end of the program.
  static const bool quiet = H5dont_atexit() >= 0;
  static_cast<void>(quiet);
  static std::mutex mutex;
  return mutex;
}

/// An open file; closed when it goes. Who has one holds the library's mutex.
class Library {
 public:
  /// `shown` is what messages call the file.
  Library(const std::filesystem::path& path, int mode, std::string shown) : name_(std::move(shown)) {
    cg_set_file_type(CG_FILE_HDF5);
    if (cg_open(path.c_str(), mode, &file_) != CG_OK) fail("", cg_get_error());
    open_ = true;
  }
  ~Library() {
    if (open_) cg_close(file_);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  int file() const { return file_; }
  /// That the file is of, in thousandths: 3400 of version 3.4.
  int version() const {
    float version = 0;
    check(cg_version(file_, &version), "");
    return static_cast<int>(std::lround(1000 * version));
  }
  void check(int status, const std::string& entity) const {
    if (status != CG_OK) fail(entity, cg_get_error());
  }
  [[noreturn]] void fail(const std::string& entity, const std::string& reason) const {
    throw InputError(name_, entity, reason);
  }
  void close() {
    open_ = false;
    check(cg_close(file_), "");
  }

 private:
  std::string name_;
  int file_ = 0;
  bool open_ = false;
};

inline constexpr int kBase = 1;  ///< the only one that is read or written

}  // namespace weft::meshing::cgns
