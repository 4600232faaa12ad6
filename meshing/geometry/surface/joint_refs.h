// References that also tell the face or the edge of the model.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/geometry/model/geometry_model.h"

namespace weft::meshing {

struct JointRef {
  std::int32_t ref = 0;
  std::uint32_t entity = kNoEntity;  ///< face, of several that are one the lowest; or edge
  friend auto operator<=>(const JointRef&, const JointRef&) = default;
};

/// Each joint reference has a number, that of nothing 0.
class JointRefs {
 public:
  /// Of these, in any order.
  explicit JointRefs(std::vector<JointRef> refs = {}) : refs_(std::move(refs)) {
    std::erase(refs_, JointRef{});
    sort_unique(refs_);
    refs_.insert(refs_.begin(), JointRef{});
  }
  std::int32_t number(const JointRef& ref) const {
    if (ref == JointRef{}) return 0;
    return static_cast<std::int32_t>(1 + place_in(std::span(refs_).subspan(1), ref));
  }
  const JointRef& operator[](std::int32_t number) const { return refs_[static_cast<std::size_t>(number)]; }
  /// By number, whether a model tells the shape there.
  std::vector<bool> on_model() const {
    std::vector<bool> result;
    for (const JointRef& ref : refs_) result.push_back(ref.entity != kNoEntity);
    return result;
  }

 private:
  std::vector<JointRef> refs_;  // nothing, then the others ascending
};

}  // namespace weft::meshing
