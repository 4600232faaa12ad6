// Adapts a mesh that a program holds in parts, on a communicator of its own: mpirun -n 4 parts_on_mpi
#include <weft/weft.h>

#include <cstdio>
#include <map>

/// The tets of a box that are this rank's by a rule of the program's own; the last rank of several has none.
weft::Part my_part(const weft::Mesh& whole, int rank, int ranks) {
  const int holders = ranks > 1 ? ranks - 1 : 1;
  weft::Part part;
  std::map<std::uint32_t, std::uint32_t> local;
  for (std::uint32_t t = 0; t < whole.tets.size(); ++t) {
    if (static_cast<int>(t / 7) % holders != rank) continue;
    std::array<std::uint32_t, 4> tet{};
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t v = whole.tets[t][i];
      const auto [at, added] = local.try_emplace(v, static_cast<std::uint32_t>(part.ids.size()));
      if (added) {
        part.ids.push_back(v);
        part.mesh.points.push_back(whole.points[v]);
      }
      tet[i] = at->second;
    }
    part.mesh.tets.push_back(tet);
    part.tet_ids.push_back(t);
  }
  return part;
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int world_rank = 0, rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &world_rank);
  MPI_Comm solvers;  // ranks in the opposite order, as in a program that has split its world
  MPI_Comm_split(MPI_COMM_WORLD, 0, -world_rank, &solvers);
  MPI_Comm_rank(solvers, &rank);
  MPI_Comm_size(solvers, &ranks);

  weft::BoxOptions cells;
  cells.cells = {6, 6, 6};
  const weft::Part part = my_part(weft::box(cells), rank, ranks);
  const weft::Metric metric = weft::Metric::from_sizes(std::vector<double>(part.ids.size(), 0.12));

  weft::Options options;
  options.run.threads = 1;
  options.distributed.subdomains = 4;
  options.distributed.ghosts = true;
  const weft::PartResult fine = weft::adapt(solvers, part, metric, options);
  std::printf("rank %d: %zu tets, %zu ghosts\n", rank, fine.part.num_own_tets,
              fine.part.mesh.tets.size() - fine.part.num_own_tets);
  if (rank == 0)
    std::printf("all: %llu tets, volume %.12g\n", static_cast<unsigned long long>(fine.after->num_tets),
                fine.after->volume);
  MPI_Comm_free(&solvers);
  MPI_Finalize();
  return fine.goal_met() ? 0 : 1;
}
