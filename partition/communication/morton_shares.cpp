// Keys, and where the shares begin.
#include "partition/communication/morton_shares.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "meshing/base/morton.h"
#include "partition/communication/reduce.h"

namespace weft::partition {

using meshing::Box;
using meshing::Point;

Box common_box(Peers& peers, const Box& box) {
  const std::vector<double> most =
      partition::max(peers, std::vector{-box.lo.x, -box.lo.y, -box.lo.z, box.hi.x, box.hi.y, box.hi.z});
  return {{-most[0], -most[1], -most[2]}, {most[3], most[4], most[5]}};
}

std::vector<std::uint64_t> morton_keys(std::span<const Point> points, const Box& box) {
  const meshing::MortonCurve curve(box);
  std::vector<std::uint64_t> keys;
  keys.reserve(points.size());
  for (const Point& p : points) keys.push_back(curve.key(p));
  return keys;
}

std::vector<std::uint64_t> first_keys(Peers& peers, std::vector<std::uint64_t> keys) {
  constexpr std::size_t kSamples = 64;
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint64_t> samples;
  for (std::size_t i = 0; i < kSamples && !keys.empty(); ++i)
    samples.push_back(keys[keys.size() * i / kSamples]);
  std::vector<std::uint64_t> all = allgather_joined(peers, samples);
  std::sort(all.begin(), all.end());
  const auto ranks = static_cast<std::size_t>(peers.ranks());
  std::vector<std::uint64_t> firsts;
  for (std::size_t r = 1; r < ranks && !all.empty(); ++r) firsts.push_back(all[all.size() * r / ranks]);
  return firsts;
}

std::vector<std::uint32_t> MortonShares::owners(std::span<const Point> points) const {
  std::vector<std::uint32_t> ranks;
  ranks.reserve(points.size());
  for (const std::uint64_t key : morton_keys(points, box))
    ranks.push_back(static_cast<std::uint32_t>(std::ranges::upper_bound(firsts, key) - firsts.begin()));
  return ranks;
}

MortonShares morton_shares(Peers& peers, std::initializer_list<std::span<const Point>> meshes) {
  std::vector<Point> finite;
  for (const std::span<const Point> points : meshes)
    std::ranges::copy_if(points, std::back_inserter(finite),
                         [](const Point& p) { return std::isfinite(p.x + p.y + p.z); });
  Box mine;
  for (const Point& p : finite) mine.include(p);
  MortonShares shares{common_box(peers, mine), {}};
  shares.firsts = first_keys(peers, morton_keys(finite, shares.box));
  return shares;
}

}  // namespace weft::partition
