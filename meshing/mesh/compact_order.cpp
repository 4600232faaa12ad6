// Bisection of the tets' centres.
#include "meshing/mesh/compact_order.h"

#include <algorithm>
#include <numeric>

#include "meshing/base/box.h"

namespace weft::meshing {
namespace {

struct Extent {
  Point centre;  ///< twice
  Point size;
};

class Bisection {
 public:
  Bisection(std::span<const Point> points, std::span<const std::array<std::uint32_t, 4>> tets,
            std::size_t run)
      : run_(run), order_(tets.size()) {
    extents_.reserve(tets.size());
    for (const auto& tet : tets) {
      Box box;
      for (const std::uint32_t v : tet) box.include(points[v]);
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
  return Bisection(points, tets, run).run();
}

}  // namespace weft::meshing
