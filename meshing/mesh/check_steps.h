// The steps of check_mesh() and of the checks of a mesh in parts that look at one entity at a time: arrays,
// orientations, sums.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "meshing/base/compensated_sum.h"
#include "meshing/mesh/mesh_data.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/problems.h"

namespace weft::meshing::checks {

using Triangle = std::array<std::uint32_t, 3>;
using Tet = std::array<std::uint32_t, 4>;

inline constexpr std::size_t kChunk = 1 << 15;

inline std::size_t num_chunks(std::size_t n) { return (n + kChunk - 1) / kChunk; }

/// Runs body(chunk, begin, end) for fixed chunks of [0, n) in parallel: per-chunk results put together in
/// chunk order are the same for any number of threads.
template <class Body>
void for_chunks(std::size_t n, const Body& body) {
  tbb::parallel_for(std::size_t{0}, num_chunks(n),
                    [&](std::size_t c) { body(c, c * kChunk, std::min(n, (c + 1) * kChunk)); });
}

/// The same for a body(begin, end, problems) that finds problems.
template <class Body>
void find_in_chunks(std::size_t n, Problems& problems, const Body& body) {
  std::vector<Problems> found(num_chunks(n), problems.fresh());
  for_chunks(n, [&](std::size_t c, std::size_t begin, std::size_t end) { body(begin, end, found[c]); });
  for (Problems& f : found) problems.append(std::move(f));
}

template <std::size_t N>
void check_vertices(const char* entity, const std::vector<std::array<std::uint32_t, N>>& entities,
                    std::size_t num_points, Problems& problems, std::uint64_t passed = 0) {
  find_in_chunks(entities.size(), problems, [&](std::size_t begin, std::size_t end, Problems& found) {
    for (std::size_t e = begin; e < end; ++e) {
      auto v = entities[e];
      std::sort(v.begin(), v.end());
      if (v[N - 1] >= num_points)
        found.add(entity, ' ', passed + e + 1, ": vertex ", std::uint64_t{v[N - 1]} + 1, " is out of range (",
                  num_points, " points)");
      if (const auto twice = std::adjacent_find(v.begin(), v.end()); twice != v.end())
        found.add(entity, ' ', passed + e + 1, ": vertex ", std::uint64_t{*twice} + 1, " appears twice");
    }
  });
}

inline void check_references(const char* entity, std::size_t num_refs, std::size_t num_entities,
                             Problems& problems) {
  if (num_refs != num_entities)
    problems.add(entity, " references: ", num_refs, " given for ", num_entities, " entities");
}

inline void check_list(const char* list, const std::vector<std::uint32_t>& indices, std::size_t limit,
                       Problems& problems) {
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= limit)
      problems.add(list, ' ', i + 1, ": index ", std::uint64_t{indices[i]} + 1, " is out of range (", limit,
                   " entities)");
}

inline void check_coordinates(const std::vector<Point>& points, Problems& problems,
                              std::uint64_t passed = 0) {
  for (std::size_t p = 0; p < points.size(); ++p)
    if (!std::isfinite(points[p].x) || !std::isfinite(points[p].y) || !std::isfinite(points[p].z))
      problems.add("vertex ", passed + p + 1, ": a coordinate is not finite");
}

/// The sign of a tet's orientation; one that is not positive is a problem of the tet with this number.
inline std::int8_t check_orientation(std::uint64_t number, const std::array<Point, 4>& p,
                                     Problems& problems) {
  const auto sign = static_cast<std::int8_t>(orientation(p[0], p[1], p[2], p[3]));
  if (sign < 0) problems.add("tet ", number + 1, ": inverted (its orientation is negative)");
  if (sign == 0) problems.add("tet ", number + 1, ": flat (its orientation is zero)");
  return sign;
}

using SumsByRef = std::map<std::int32_t, CompensatedSum>;

inline void add(const CompensatedSum& part, CompensatedSum& sum) {
  sum.add(part.sum);
  sum.add(part.lost);
}

/// size(i) of entity i, by its reference.
template <class Size>
SumsByRef sum_by_ref(const std::vector<std::int32_t>& refs, const Size& size) {
  std::vector<SumsByRef> parts(num_chunks(refs.size()));
  for_chunks(refs.size(), [&](std::size_t c, std::size_t begin, std::size_t end) {
    auto part = parts[c].end();  // neighbours mostly have the same reference
    for (std::size_t e = begin; e < end; ++e) {
      if (part == parts[c].end() || part->first != refs[e]) part = parts[c].try_emplace(refs[e]).first;
      part->second.add(size(e));
    }
  });
  SumsByRef sums;
  for (const SumsByRef& part : parts)
    for (const auto& [ref, sum] : part) add(sum, sums[ref]);
  return sums;
}

inline std::map<std::int32_t, double> values_of(const SumsByRef& sums) {
  std::map<std::int32_t, double> values;
  for (const auto& [ref, sum] : sums) values[ref] = sum.value();
  return values;
}

inline double volume_of(const std::array<Point, 4>& p) { return six_volume(p[0], p[1], p[2], p[3]) / 6; }
inline double area_of(const std::array<Point, 3>& p) { return norm(cross(p[1] - p[0], p[2] - p[0])) / 2; }

/// Volumes by reference, and their sum.
inline void put_volumes(const SumsByRef& sums, CheckReport& report) {
  report.volume_by_ref = values_of(sums);
  CompensatedSum volume;
  for (const auto& [ref, part] : report.volume_by_ref) volume.add(part);
  report.volume = volume.value();
}

}  // namespace weft::meshing::checks
