// Adapts a box to smaller tets, checks the result and writes it: the library with one mesh.
#include <weft/weft.h>

#include <cstdio>

int main() {
  weft::BoxOptions cells;
  cells.cells = {6, 6, 6};
  const weft::Mesh start = weft::box(cells);

  weft::Options options;
  options.metric.function = "uniform:0.1";
  options.run.threads = 1;
  options.run.progress = [](const weft::Progress& now) {
    std::printf("%s: %.0f %%\n", now.stage.c_str(), 100 * now.done);
    return true;  // false would end the run with the mesh that it has
  };

  const weft::Result fine = weft::adapt(start, options);
  if (!weft::verify(fine.mesh).ok()) return 1;
  weft::write_result("fine.meshb", fine.mesh, fine.metric);
  std::printf("weft %s: %zu tets, %.1f %% of the edges are unit\n", weft::version(), fine.mesh.tets.size(),
              100 * fine.after->edges_unit);
  return fine.goal_met() ? 0 : 1;
}
