// Versions of MPI and TBB are those of the libraries that run, the others those that CMake found.
#include "tools/library/version.h"

#include <fmt/format.h>
#include <tbb/version.h>

#include <string_view>

#include "engine/mpi/mpi_version.h"
#include "weft/weft.h"

namespace weft {
namespace {

std::string compiler() {
#if defined(__clang__)
  return "Clang " __clang_version__;
#elif defined(__GNUC__)
  return "GCC " __VERSION__;
#else
  return "unknown";
#endif
}

/// The levels of the x86-64 psABI, by an instruction set that each begins with.
std::string_view processor_level() {
#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512VL__)
  return "x86-64-v4";
#elif defined(__AVX2__) && defined(__FMA__)
  return "x86-64-v3";
#elif defined(__SSE4_2__)
  return "x86-64-v2";
#elif defined(__x86_64__)
  return "x86-64";
#elif defined(__aarch64__)
  return "aarch64";
#else
  return "unknown";
#endif
}

std::string assertions() {
#ifdef WEFT_ASSERTION_LEVEL
  constexpr const char* kLevels[] = {"none", "light", "normal", "heavy"};
  return kLevels[WEFT_ASSERTION_LEVEL];
#else
  return "none";
#endif
}

}  // namespace

std::string version_details() {
  std::string text = fmt::format("weft {}", tools::kVersion);
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("\n{:<11} {}", name, value);
  };
  line("compiler", compiler());
  line("MPI", engine::mpi_version());
  line("TBB", TBB_runtime_version());
  line("CGAL", WEFT_CGAL_VERSION);
  line("Ceres", WEFT_CERES_VERSION);
  line("Eigen", WEFT_EIGEN_VERSION);
  line("METIS", WEFT_METIS_VERSION);
  line("HDF5", WEFT_HDF5_VERSION);
  line("CGNS", WEFT_CGNS_VERSION);
  line("processor", fmt::format("{}{}", processor_level(), WEFT_FOR_THIS_MACHINE ? ", native" : ""));
  line("assertions", assertions());
  return text;
}

}  // namespace weft
