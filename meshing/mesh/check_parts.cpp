// The walk through faces, on those tets that are here.
#include "meshing/mesh/check_parts.h"

#include <algorithm>

#include "meshing/mesh/check_steps.h"

namespace weft::meshing {

using namespace checks;

namespace {

std::uint64_t count_used(const Stars& stars) {
  std::vector<std::uint8_t> used(stars.end - stars.first, 0);
  for (const Tet& tet : stars.mesh.tets)
    for (const std::uint32_t v : tet)
      if (v >= stars.first && v < stars.end) used[v - stars.first] = 1;
  return static_cast<std::uint64_t>(std::ranges::count(used, 1));
}

}  // namespace

StarsReport check_stars(const Stars& stars, std::size_t max_problems) {
  FaceCheck faces(stars.mesh, stars.signs, {stars.tet_numbers, stars.first, stars.end});
  StarsReport report{Problems(max_problems), {}, {}};
  faces.run(report.problems);
  report.matched = faces.matched();
  report.component.resize(stars.mesh.tets.size());
  for (std::uint32_t t = 0; t < report.component.size(); ++t)
    report.component[t] = faces.components().root(t);
  report.touching_edges = faces.count_touching_edges();
  report.balls = faces.count_balls();
  report.used = count_used(stars);
  return report;
}

}  // namespace weft::meshing
