// A vertex is looked up among the planes once; a tet between the same planes as all its vertices is passed
// over by comparing four words.
#include "tools/report/cut_tets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstddef>

#include "meshing/base/parallel.h"

namespace weft::report {
namespace {

using meshing::MeshData;
using Lists = std::vector<std::vector<std::uint32_t>>;

/// Along each axis the number of planes that a vertex is in front of. The fourth makes it a word.
using Slots = std::array<std::uint16_t, 4>;

std::uint64_t word_of(const Slots& slots) { return std::bit_cast<std::uint64_t>(slots); }

std::vector<Slots> slots_of_vertices(const MeshData& mesh, const AxisPlanes& planes) {
  std::vector<Slots> slots(mesh.points.size());
  meshing::for_each_index(slots.size(), [&](std::size_t v) {
    for (std::size_t a = 0; a < 3; ++a) {
      const double x = mesh.points[v][static_cast<int>(a)];
      const auto next = std::ranges::lower_bound(planes[a], x);
      slots[v][a] = static_cast<std::uint16_t>(next - planes[a].begin());
    }
  });
  return slots;
}

/// Adds a tet to the lists of the planes that its vertices lie on different sides of.
void add_cuts(std::uint32_t tet, const std::array<Slots, 4>& of_vertices, const AxisPlanes& planes,
              Lists& lists) {
  std::size_t first = 0;  // the list of the axis' first plane
  for (std::size_t a = 0; a < 3; first += planes[a++].size()) {
    const auto [lo, hi] =
        std::minmax({of_vertices[0][a], of_vertices[1][a], of_vertices[2][a], of_vertices[3][a]});
    for (std::size_t plane = lo; plane < hi; ++plane) lists[first + plane].push_back(tet);
  }
}

}  // namespace

std::vector<std::vector<std::uint32_t>> cut_tets(const MeshData& mesh, const AxisPlanes& planes) {
  constexpr std::size_t kTetsPerRun = 1 << 14;
  const std::size_t count = planes[0].size() + planes[1].size() + planes[2].size();
  const std::vector<Slots> slots = slots_of_vertices(mesh, planes);
  std::vector<Lists> of_runs((mesh.tets.size() + kTetsPerRun - 1) / kTetsPerRun, Lists(count));
  tbb::parallel_for(std::size_t{0}, of_runs.size(), [&](std::size_t run) {
    const std::size_t end = std::min(mesh.tets.size(), (run + 1) * kTetsPerRun);
    for (std::size_t t = run * kTetsPerRun; t < end; ++t) {
      const auto& [a, b, c, d] = mesh.tets[t];
      const std::array<Slots, 4> mine = {slots[a], slots[b], slots[c], slots[d]};
      const std::uint64_t first = word_of(mine[0]);
      if (word_of(mine[1]) == first && word_of(mine[2]) == first && word_of(mine[3]) == first) continue;
      add_cuts(static_cast<std::uint32_t>(t), mine, planes, of_runs[run]);
    }
  });
  Lists all(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t plane) {
    for (const Lists& lists : of_runs)
      all[plane].insert(all[plane].end(), lists[plane].begin(), lists[plane].end());
  });
  return all;
}

}  // namespace weft::report
