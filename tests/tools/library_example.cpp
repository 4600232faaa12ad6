// The program of the top README, word for word: tests build and run it, so that it stays true.
#include "meshing/adapt/adapt.h"
#include "meshing/io/mesh_file.h"

using namespace weft::meshing;

int main() {
  const MeshData mesh = read_mesh("wing.meshb");
  LogMetricField metric = metric_from_solution(read_solution("wing.solb"), mesh.points.size(), "wing.solb");
  scale_to_complexity(mesh, 5000, metric);
  AdaptOptions options;
  options.threads = 8;
  const AdaptResult result = adapt(mesh, {&mesh, &metric}, options);
  write_mesh("fine.meshb", result.mesh);
  write_solution("fine.solb", solution_from_metric(result.log_metrics));
}
