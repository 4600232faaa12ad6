// The vertices that a subdomain shares with others, and with which.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/ids.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// One holder of one vertex. Plain data, ordered by vertex, then subdomain.
struct Holder {
  GlobalId vertex;
  SubdomainId subdomain;
  friend auto operator<=>(const Holder&, const Holder&) = default;
};

/// Sorts the lines and drops repeated ones.
void sort_unique(std::vector<Holder>& lines);

/// All lines of several sorted lists, sorted, none twice.
std::vector<Holder> merge_unique(std::vector<std::vector<Holder>> lists);

/// The interface of one subdomain: a table of vertices sorted by id, each with the other subdomains that hold
/// it, ascending.
class Interface {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;

  Interface() = default;
  /// From one line for each vertex and each *other* holder of it.
  explicit Interface(std::vector<Holder> lines);

  std::uint32_t size() const { return static_cast<std::uint32_t>(ids_.size()); }
  GlobalId id(std::uint32_t i) const { return ids_[i]; }
  /// The index of a vertex, kNone for one that is not shared.
  std::uint32_t find(GlobalId id) const;
  std::span<const Holder> others(std::uint32_t i) const {
    return {lines_.data() + begins_[i], lines_.data() + begins_[i + 1]};
  }
  bool held_by(std::uint32_t i, SubdomainId other) const;
  std::span<const Holder> lines() const { return lines_; }
  /// All other holders of any vertex, ascending.
  std::span<const SubdomainId> neighbours() const { return neighbours_; }

  /// Where the vertex is in the mesh; invalid until set.
  meshing::VertexId local(std::uint32_t i) const { return locals_[i]; }
  void set_local(std::uint32_t i, meshing::VertexId v) { locals_[i] = v; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(lines_, ids_, begins_, neighbours_, locals_);
  }

 private:
  std::vector<Holder> lines_;
  std::vector<GlobalId> ids_;
  std::vector<std::uint32_t> begins_{0};
  std::vector<SubdomainId> neighbours_;
  std::vector<meshing::VertexId> locals_;
};

}  // namespace weft::partition
