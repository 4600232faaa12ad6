// A solver and adaptation in turns, in memory: the metric comes from the solution, the solution goes along.
#include <weft/weft.h>

#include <cmath>
#include <cstdio>

/// Stands for a flow solver: what it would find on this mesh.
weft::Fields solve(const weft::Mesh& mesh) {
  weft::Field u{weft::Field::Kind::scalar, {}, "u"};
  for (const weft::Point& p : mesh.points) u.values.push_back(std::tanh(50 * (p.x + 0.3 * p.y * p.y - 0.6)));
  return {mesh.points.size(), {u}};
}

int main() {
  weft::BoxOptions cells;
  cells.cells = {6, 6, 6};
  weft::Mesh mesh = weft::box(cells);
  weft::Fields solution = solve(mesh);
  for (const double complexity : {1000.0, 2000.0}) {
    weft::Options options;
    options.metric.solutions = {solution};
    options.metric.complexity = complexity;
    options.metric.hgrad = 1.5;
    options.transfer = weft::TransferMethod::conservative;
    weft::Result fine = weft::adapt(mesh, options, solution);
    std::printf("complexity %.0f: %zu tets, integral of u changed by %.1e\n", complexity,
                fine.mesh.tets.size(),
                fine.field_accounts[0].integral_after - fine.field_accounts[0].integral_before);
    mesh = std::move(fine.mesh);
    solution = solve(mesh);  // a real solver would start from fine.fields
  }
  return weft::verify(mesh).ok() ? 0 : 1;
}
