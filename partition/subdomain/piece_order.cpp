// Bisection of the tets' centres down to runs of the size of a piece.
#include "partition/subdomain/piece_order.h"

#include <algorithm>
#include <numeric>

#include "meshing/base/box.h"
#include "partition/subdomain/background_store.h"

namespace weft::partition {
namespace {

using meshing::Box;
using meshing::Point;

struct Extent {
  Point centre;  ///< twice
  Point size;
};

class Bisection {
 public:
  Bisection(std::span<const Point> points, std::span<const std::array<std::uint32_t, 4>> tets)
      : order_(tets.size()) {
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
  void split(std::span<std::uint32_t> run) {
    const std::size_t pieces = (run.size() + kTetsOfPiece - 1) / kTetsOfPiece;
    if (pieces < 2) {
      std::ranges::sort(run);  // as they were: an input's neighbours are near each other
      return;
    }
    const std::size_t half = pieces / 2 * kTetsOfPiece;
    const int axis = longest_axis(run);
    std::nth_element(run.begin(), run.begin() + static_cast<std::ptrdiff_t>(half), run.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double x = extents_[a].centre[axis], y = extents_[b].centre[axis];
                       return x != y ? x < y : a < b;
                     });
    split(run.first(half));
    split(run.subspan(half));
  }

  /// Along which most tets follow each other: stretched ones lie side by side across their long axis.
  int longest_axis(std::span<const std::uint32_t> run) const {
    Box centres;
    Point sizes;
    for (const std::uint32_t t : run) {
      centres.include(extents_[t].centre);
      sizes += extents_[t].size;
    }
    const Point length = centres.size();
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
      if (length[axis] * sizes[longest] > length[longest] * sizes[axis]) longest = axis;
    return longest;
  }

  std::vector<Extent> extents_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

std::vector<std::uint32_t> piece_order(std::span<const Point> points,
                                       std::span<const std::array<std::uint32_t, 4>> tets) {
  return Bisection(points, tets).run();
}

}  // namespace weft::partition
