// Origin and possible holders of the vertices of an interface that is being refined: the side or face of the
// initial interface in which each lies, and the other subdomains that may hold it.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "partition/subdomain/interface.h"

namespace weft::partition {

/// Initial vertices, in the order of the interface, then new ones.
class RefinedVertices {
 public:
  using Index = std::uint32_t;
  static constexpr Index kNone = 0xFFFFFFFFu;

  RefinedVertices() = default;
  /// `phase`: Subdomain::phase; names of new vertices differ from those of other phases.
  explicit RefinedVertices(const Interface& interface, std::uint32_t phase = 0);

  Index size() const { return static_cast<Index>(vertices_.size()); }
  Index first_new() const { return first_new_; }
  GlobalId id(Index i) const { return vertices_[i].id; }
  /// Initial vertices of the side or face in which a new vertex lies; an initial one is its own. Padded with
  /// kNone.
  const std::array<Index, 3>& corners(Index i) const { return vertices_[i].corners; }
  /// Other subdomains that may hold the vertex, ascending.
  const std::vector<SubdomainId>& holders(Index i) const { return sets_[vertices_[i].holders]; }

  /// Adds the vertex between two that have an edge in one face of the interface, and returns its index.
  Index add_between(Index x, Index y);
  /// Orders new vertices by id. Their indices change.
  void sort_new();
  /// kNone for an unknown vertex. New ones must be sorted.
  Index find(GlobalId id) const;

 private:
  /// Few sets of holders, which many vertices share.
  using SetIndex = std::uint32_t;
  struct Vertex {
    GlobalId id;
    std::array<Index, 3> corners{kNone, kNone, kNone};
    SetIndex holders = 0;
  };

  SetIndex find_or_add(std::vector<SubdomainId> set);
  SetIndex common(SetIndex x, SetIndex y);

  std::uint32_t phase_ = 0;
  std::vector<Vertex> vertices_;
  Index first_new_ = 0;
  std::vector<std::vector<SubdomainId>> sets_;
  std::map<std::vector<SubdomainId>, SetIndex> index_of_set_;
  std::map<std::pair<SetIndex, SetIndex>, SetIndex> common_;
};

}  // namespace weft::partition
