// How much work an adaptation is, predicted: what percentages of time are made of. In microseconds of one
// core for all tets together; only ratios matter.
#pragma once

#include <array>
#include <cstdint>

namespace weft::meshing {

struct PredictedWork {
  double import = 0, collapse = 0, create = 0, reconnect = 0, improve = 0, output = 0;

  double sum() const { return import + collapse + create + reconnect + improve + output; }
};
/// Of a mesh of `tets` that is to have `wanted` in the end.
PredictedWork predict_work(double tets, double wanted);

/// A tet's part in the passes of a round that creates points, and in a round of reconnection; measured with
/// one thread on cube-polar2 to 50,000, the delta wing to 100,000 and a mesh made ten times coarser.
namespace work {
inline constexpr double kSplit = 0.5, kCollapse = 0.4, kSwap = 0.15, kSmoothAndCollapse = 1.0;
inline constexpr double kRound = kSplit + kCollapse + kSwap + kSmoothAndCollapse;
/// Every round of reconnection changes less than the one before.
inline constexpr std::array<double, 6> kReconnect = {2.4, 1.8, 1.3, 1.0, 0.55, 0.3};
inline constexpr double kImprove = 0.1;

/// Rounds that are to come before splits have become rare, after one that has made `splits` in a mesh of
/// `tets`: each makes about a third of those of the one before, and none follows one with less than a
/// fiftieth of the tets.
double rounds_after(std::uint64_t splits, double tets);
/// Of reconnection, from round `first` on.
double reconnection(std::size_t first, double tets);
}  // namespace work

/// The share of an adaptation that is done, made of the work that is done and what is predicted to be left.
class WorkMeter {
 public:
  /// The prediction is replaced by a better one.
  void expect(double left) { left_ = left; }
  /// Work that was predicted has been done.
  void spend(double work);
  /// Where `ahead` of what is predicted is done besides. Never less than before.
  double share(double ahead);

 private:
  double done_ = 0, left_ = 0, share_ = 0;
};

}  // namespace weft::meshing
