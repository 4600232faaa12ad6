// A mesh file of text that all ranks write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "meshing/io/mesh_file.h"
#include "partition/communication/peers.h"
#include "partition/output/common_file.h"
#include "partition/output/text_places.h"

namespace weft::partition {

/// What is done with one part of the mesh, and where that stands among all.
using PartAction = std::function<void(std::uint64_t order, const meshing::MeshPart& part)>;

/// Until it can appear. Rows are made twice: once for their length, which gives all their places.
class CommonText {
 public:
  /// `for_parts` calls its argument with each part that is here; `whole` outlives the object.
  CommonText(const std::filesystem::path& name, const meshing::WholeMesh& whole,
             std::function<void(const PartAction&)> for_parts)
      : file_(name), whole_(whole), for_parts_(std::move(for_parts)) {}

  /// All ranks.
  void create(Peers& peers);
  /// This rank's parts. Throws meshing::InputError.
  void write();
  /// All ranks, when all have written.
  void deliver(Peers& peers) { file_.deliver(peers); }
  /// On rank 0, when all has been delivered.
  void commit() { file_.commit(); }

 private:
  CommonFile file_;
  const meshing::WholeMesh& whole_;
  std::function<void(const PartAction&)> for_parts_;
  std::vector<std::string> heads_;  ///< of the sections; on rank 0
  TextPlaces places_;
};

}  // namespace weft::partition
