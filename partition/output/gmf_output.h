// A GMF file, binary or text, that all ranks write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include "meshing/io/gmf/gmf_slice_writer.h"
#include "partition/communication/peers.h"
#include "partition/output/common_file.h"
#include "partition/output/text_places.h"

namespace weft::partition {

/// What one part has of each section, in the order of parts.
struct GmfPart {
  std::uint64_t order;  ///< where it stands among all
  std::function<void(meshing::GmfSliceWriter&)> write;
};

/// Until it can appear. Rows of text are made twice: once for their length, which gives all their places.
class GmfOutput {
 public:
  GmfOutput(const std::filesystem::path& name, meshing::GmfPlan plan, std::vector<GmfPart> parts)
      : file_(name), plan_(std::move(plan)), parts_(std::move(parts)) {}

  /// All ranks.
  void create(Peers& peers);
  /// This rank's parts, by as many writers as there are threads (TBB, in the caller's arena). Throws
  /// meshing::InputError.
  void write();
  /// All ranks, when all have written.
  void deliver(Peers& peers) { file_.deliver(peers); }
  /// On rank 0, when all has been delivered.
  void commit() { file_.commit(); }

 private:
  CommonFile file_;
  meshing::GmfPlan plan_;
  std::vector<GmfPart> parts_;
  TextPlaces places_;
  bool first_ = false;  ///< the rank that writes what is no row
};

}  // namespace weft::partition
