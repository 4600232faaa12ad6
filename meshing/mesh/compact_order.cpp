// Bisection of the tets' centres.
#include "meshing/mesh/compact_order.h"

#include <algorithm>
#include <numeric>

namespace weft::meshing {
namespace {

struct Extent {
  Point centre;  ///< twice
  Point size;
};

class Bisection {
 public:
  /// box_of(i) of `count` tets.
  template <class BoxOf>
  Bisection(std::size_t count, const BoxOf& box_of, std::size_t run) : run_(run), order_(count) {
    extents_.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Box box = box_of(i);
      extents_.push_back({box.lo + box.hi, box.size()});
    }
    std::iota(order_.begin(), order_.end(), 0u);
  }

  std::vector<std::uint32_t> run() {
    split(order_);
    return std::move(order_);
  }

 private:
  void split(std::span<std::uint32_t> tets) {
    const std::size_t runs = (tets.size() + run_ - 1) / run_;
    if (runs < 2) {
      std::ranges::sort(tets);  // as they were: an input's neighbours are near each other
      return;
    }
    const std::size_t half = runs / 2 * run_;
    const int axis = longest_axis(tets);
    std::nth_element(tets.begin(), tets.begin() + static_cast<std::ptrdiff_t>(half), tets.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double x = extents_[a].centre[axis], y = extents_[b].centre[axis];
                       return x != y ? x < y : a < b;
                     });
    split(tets.first(half));
    split(tets.subspan(half));
  }

  /// Along which most tets follow each other: stretched ones lie side by side across their long axis.
  int longest_axis(std::span<const std::uint32_t> tets) const {
    Box centres;
    Point sizes;
    for (const std::uint32_t t : tets) {
      centres.include(extents_[t].centre);
      sizes += extents_[t].size;
    }
    const Point length = centres.size();
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
      if (length[axis] * sizes[longest] > length[longest] * sizes[axis]) longest = axis;
    return longest;
  }

  std::size_t run_;
  std::vector<Extent> extents_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

std::vector<std::uint32_t> compact_order(std::span<const Point> points,
                                         std::span<const std::array<std::uint32_t, 4>> tets,
                                         std::size_t run) {
  const auto box_of = [&](std::size_t t) {
    Box box;
    for (const std::uint32_t v : tets[t]) box.include(points[v]);
    return box;
  };
  return Bisection(tets.size(), box_of, run).run();
}

std::vector<std::uint32_t> compact_order(std::span<const Box> boxes, std::size_t run) {
  return Bisection(
             boxes.size(), [&](std::size_t i) { return boxes[i]; }, run)
      .run();
}

}  // namespace weft::meshing
