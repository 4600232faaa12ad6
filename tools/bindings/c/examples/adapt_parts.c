/* Adapts a box that the ranks have slabs of, on a communicator of the program's own: mpirun -n 4 adapt_parts
 */
#include <stdio.h>
#include <stdlib.h>
#include <weft/weft-c.h>

enum { kCells = 6, kSide = kCells + 1 };

/* Six tets round the diagonal of a cell, by its corners in binary. */
static const int kTets[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

/* The layers of cells from `first` up to `last`, as a part: ids are those of the points of the whole box. */
static weft_status make_slab(int first, int last, weft_part** part, weft_metric** metric) {
  const int64_t layers = last - first, points = layers > 0 ? (layers + 1) * kSide * kSide : 0;
  const int64_t tets = 6 * layers * kCells * kCells;
  double* xyz = malloc((size_t)(points + 1) * 3 * sizeof *xyz);
  double* sizes = malloc((size_t)(points + 1) * sizeof *sizes);
  int64_t* ids = malloc((size_t)(points + 1) * sizeof *ids);
  int64_t* corners = malloc((size_t)(tets + 1) * 4 * sizeof *corners);
  for (int64_t p = 0; p < points; ++p) {
    ids[p] = p + (int64_t)first * kSide * kSide;
    xyz[3 * p] = (double)(p % kSide) / kCells;
    xyz[3 * p + 1] = (double)(p / kSide % kSide) / kCells;
    xyz[3 * p + 2] = (double)(ids[p] / (kSide * kSide)) / kCells;
    sizes[p] = 0.12;
  }
  for (int64_t t = 0; t < tets; ++t)
    for (int i = 0; i < 4; ++i) {
      const int64_t cell = t / 6, corner = kTets[t % 6][i];
      const int64_t x = cell % kCells + corner % 2, y = cell / kCells % kCells + corner / 2 % 2;
      corners[4 * t + i] = x + kSide * (y + kSide * (cell / (kCells * kCells) + corner / 4));
    }
  weft_mesh* mesh = NULL;
  weft_status status = weft_mesh_create(points, xyz, tets, corners, &mesh);
  if (!status) status = weft_part_create(mesh, ids, NULL, NULL, part);
  if (!status) status = weft_metric_from_sizes(points, sizes, metric);
  if (status) fprintf(stderr, "%s\n", weft_last_error());
  weft_free(mesh);
  free(xyz);
  free(sizes);
  free(ids);
  free(corners);
  return status;
}

int main(int argc, char** argv) {
  int rank = 0, ranks = 1;
  weft_part* part = NULL;
  weft_metric* metric = NULL;
  weft_options* options = NULL;
  weft_result* result = NULL;
  weft_measures measures = {.size = sizeof measures};
  MPI_Comm solvers;
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_split(MPI_COMM_WORLD, 0, -rank, &solvers); /* the ranks in the opposite order */
  MPI_Comm_rank(solvers, &rank);
  MPI_Comm_size(solvers, &ranks);

  /* The last of several ranks has nothing. A rank that fails here passes NULL: then all get an error. */
  const int holders = ranks > 1 ? ranks - 1 : 1;
  const int first = rank < holders ? kCells * rank / holders : kCells;
  const int last = rank < holders ? kCells * (rank + 1) / holders : kCells;
  if (make_slab(first, last, &part, &metric)) part = NULL;
  weft_options_create(NULL, &options);
  weft_options_set(options, "threads", "1");
  weft_options_set(options, "subdomains", "4");
  weft_status status = weft_adapt_parts(solvers, part, metric, options, &result);
  if (!status) status = weft_result_measures(result, &measures);
  if (status) fprintf(stderr, "rank %d: %s\n", rank, weft_last_error());
  if (!status && rank == 0)
    printf("all: %lld tets, volume %.12g\n", (long long)measures.tets, measures.volume);

  weft_free(result);
  weft_free(options);
  weft_free(metric);
  weft_free(part);
  MPI_Comm_free(&solvers);
  MPI_Finalize();
  return status ? 1 : 0;
}
