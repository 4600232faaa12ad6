// The other side of a face, for meshes that become whole again where no other threads may be asked to help.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "meshing/mesh/adjacency.h"

namespace weft::meshing {

/// Faces under their least vertices, until their other sides come. By one thread, unlike build_adjacency():
/// who unpacks a message may hold locks, and must not pick up other work meanwhile.
class FaceMatcher {
 public:
  explicit FaceMatcher(std::size_t num_vertices) : first_(num_vertices, kNone) {}

  /// The code of the face with the same vertices that has come before, which is forgotten then;
  /// kNoNeighbour, and `code` is kept, where none has.
  std::uint32_t match(std::array<std::uint32_t, 3> v, std::uint32_t code) {
    std::sort(v.begin(), v.end());
    for (std::uint32_t* link = &first_[v[0]]; *link != kNone; link = &open_[*link].next) {
      const std::uint32_t at = *link;
      if (open_[at].middle != v[1] || open_[at].largest != v[2]) continue;
      *link = open_[at].next;
      free_.push_back(at);
      return open_[at].code;
    }
    keep(v[0], {v[1], v[2], code, first_[v[0]]});
    return kNoNeighbour;
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  struct Open {
    std::uint32_t middle, largest, code, next;
  };

  void keep(std::uint32_t least, const Open& open) {
    if (free_.empty()) {
      first_[least] = static_cast<std::uint32_t>(open_.size());
      open_.push_back(open);
      return;
    }
    first_[least] = free_.back();
    free_.pop_back();
    open_[first_[least]] = open;
  }

  std::vector<std::uint32_t> first_;
  std::vector<Open> open_;
  std::vector<std::uint32_t> free_;
};

}  // namespace weft::meshing
