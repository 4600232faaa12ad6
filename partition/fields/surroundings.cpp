// Boxes of runs of tets that lie together.
#include "partition/fields/surroundings.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "meshing/mesh/compact_order.h"
#include "partition/communication/morton_shares.h"

namespace weft::partition {

using meshing::Box;
using meshing::MeshData;

Box box_of(const MeshData& mesh, const meshing::Tet& tet) {
  Box box;
  for (const std::uint32_t v : tet) box.include(mesh.points[v]);
  return box;
}

CellGrid common_grid(Peers& peers, const PartDomain& a, const PartDomain& b) {
  constexpr double kPointsPerCell = 4;
  const auto points = static_cast<double>(std::min(a.num_points(), b.num_points()));
  Box mine;
  for (const MeshData* mesh : {&a.mesh(), &b.mesh()})
    for (const meshing::Point& p : mesh->points) mine.include(p);
  return {common_box(peers, mine), points / kPointsPerCell};
}

namespace {

/// About as many tets as have the same first vertex.
constexpr std::size_t kTetsOfVertex = 6;

Box grown_box_of(const MeshData& mesh, const meshing::Tet& tet, std::span<const double> reach) {
  double farthest = 0;
  if (!reach.empty())
    for (const std::uint32_t v : tet) farthest = std::max(farthest, reach[v]);
  return box_of(mesh, tet).grown(farthest);
}

bool is_empty(const Box& box) { return box.lo.x > box.hi.x; }

double size_of(const Box& box) { return is_empty(box) ? 0 : norm2(box.size()); }

/// The size that so many boxes exceed, or fewer of equal ones; 0: all do that are not empty.
double size_of_largest(std::size_t count, std::span<const Box> boxes) {
  if (count >= boxes.size()) return 0;
  std::vector<double> sizes;
  sizes.reserve(boxes.size());
  for (const Box& box : boxes) sizes.push_back(size_of(box));
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(count);
  std::ranges::nth_element(sizes, at, std::greater());
  return *at;
}

/// Appends what runs of boxes have together, at most `most` (1 and more).
void add_united(std::span<const Box> boxes, std::size_t most, std::vector<Box>& united) {
  const std::size_t run = std::max<std::size_t>(1, (boxes.size() + most - 1) / most);
  const std::vector<std::uint32_t> order = meshing::compact_order(boxes, run);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % run == 0) united.emplace_back();
    united.back().unite(boxes[order[i]]);
  }
}

}  // namespace

std::vector<Box> boxes_of_tets(const MeshData& mesh, std::size_t most, std::span<const double> reach) {
  std::vector<Box> at_vertex(mesh.points.size());  // of the tets that it is the first vertex of
  for (const meshing::Tet& tet : mesh.tets)
    at_vertex[std::ranges::min(tet)].unite(grown_box_of(mesh, tet, reach));
  const double limit = size_of_largest(most / 2 / kTetsOfVertex, at_vertex);
  const auto is_large = [&](const Box& box) { return size_of(box) > limit; };
  std::vector<Box> alone;
  for (const meshing::Tet& tet : mesh.tets)
    if (is_large(at_vertex[std::ranges::min(tet)])) alone.push_back(grown_box_of(mesh, tet, reach));
  std::erase_if(at_vertex, [&](const Box& box) { return is_empty(box) || is_large(box); });
  std::vector<Box> boxes;
  add_united(alone, std::max<std::size_t>(1, alone.size()), boxes);
  add_united(at_vertex, std::max<std::size_t>(1, most / 2), boxes);
  return boxes;
}

std::vector<std::vector<Box>> ask_for_boxes(Peers& peers, std::span<const int> asked, const Box& where,
                                            std::span<const Box> around) {
  std::vector<std::vector<Box>> questions(static_cast<std::size_t>(peers.ranks()));
  for (const int rank : asked) questions[static_cast<std::size_t>(rank)].push_back(where);
  std::vector<std::vector<Box>> answers(questions.size());
  questions = partition::all_to_all(peers, std::move(questions));
  for (std::size_t r = 0; r < questions.size(); ++r)
    for (const Box& question : questions[r])
      std::ranges::copy_if(around, std::back_inserter(answers[r]),
                           [&](const Box& box) { return box.meets(question); });
  return partition::all_to_all(peers, std::move(answers));
}

}  // namespace weft::partition
