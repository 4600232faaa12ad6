/* Every rank reads a mesh and its metric, keeps the tets that are its share, and adapts them with the others.
   What the ranks have in common is found by the numbers of the points: no communicators of vertices or faces
   are made. mpirun -n 4 adapt_shares IN.meshb METRIC.solb COMPLEXITY */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <weft/weft-c.h>

static void check(weft_status status) {
  if (status == WEFT_OK) return;
  fprintf(stderr, "%s\n", weft_last_error());
  MPI_Abort(MPI_COMM_WORLD, 1);
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  if (argc != 4) return 64;
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);

  weft_mesh *whole = NULL, *mesh = NULL;
  weft_metric *all_metric = NULL, *metric = NULL;
  int64_t num_points, num_tets, points = 0, tets = 0;
  const double* x;
  const uint32_t* corners;
  check(weft_mesh_read(argv[1], &whole));
  check(weft_metric_read(argv[2], whole, &all_metric));
  check(weft_mesh_num_points(whole, &num_points));
  check(weft_mesh_count(whole, WEFT_TETS, &num_tets));
  check(weft_mesh_points(whole, &x));
  check(weft_mesh_tets(whole, &corners));
  double *tensors = malloc(48 * num_points), *my_points = malloc(24 * num_points),
         *my_tensors = malloc(48 * num_points);
  int64_t *local = malloc(8 * num_points), *ids = malloc(8 * num_points), *my_tets = malloc(32 * num_tets);
  check(weft_metric_get(all_metric, WEFT_ORDER_SOL, 6 * num_points, tensors));

  for (int64_t v = 0; v < num_points; ++v) local[v] = -1;
  for (int64_t t = num_tets * rank / ranks; t < num_tets * (rank + 1) / ranks; ++t, ++tets)
    for (int i = 0; i < 4; ++i) {
      const uint32_t v = corners[4 * t + i];
      if (local[v] < 0) {
        for (int k = 0; k < 3; ++k) my_points[3 * points + k] = x[3 * v + k];
        for (int k = 0; k < 6; ++k) my_tensors[6 * points + k] = tensors[6 * v + k];
        ids[points] = v;
        local[v] = points++;
      }
      my_tets[4 * tets + i] = local[v];
    }

  weft_part* part = NULL;
  weft_options* options = NULL;
  weft_result* result = NULL;
  weft_measures measures = {.size = sizeof measures};
  check(weft_mesh_create(points, my_points, tets, my_tets, &mesh));
  check(weft_metric_from_tensors(points, my_tensors, WEFT_ORDER_SOL, &metric));
  check(weft_part_create(mesh, ids, NULL, NULL, &part));
  check(weft_options_create(NULL, &options));
  check(weft_options_set(options, "threads", "1"));
  check(weft_options_set(options, "subdomains", "4"));
  check(weft_options_set(options, "complexity", argv[3]));
  const double begin = MPI_Wtime();
  check(weft_adapt_parts(MPI_COMM_WORLD, part, metric, options, &result));
  check(weft_result_measures(result, &measures));
  if (rank == 0) {
    printf("all: %lld tets, volume %.9f\n", (long long)measures.tets, measures.volume);
    fprintf(stderr, "%.2f s, mean quality %.3f, %.1f %% of the edges unit\n", MPI_Wtime() - begin,
            measures.quality_mean, 100 * measures.edges_unit);
  }
  void* handles[] = {whole, mesh, all_metric, metric, part, options, result};
  for (int i = 0; i < 7; ++i) weft_free(handles[i]);
  void* arrays[] = {tensors, my_points, my_tensors, local, ids, my_tets};
  for (int i = 0; i < 6; ++i) free(arrays[i]);
  MPI_Finalize();
  return 0;
}
