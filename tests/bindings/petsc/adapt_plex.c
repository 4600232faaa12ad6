/* A program on PETSc that knows nothing of weft: it makes a mesh by its options, distributes it, adapts it to a metric
   and tells what it has then. petsc_test.py runs it with `-dll_append libweft_petsc.so -dm_adaptor weft`.

     -cells N     the mesh: a cube of N^3 boxes of six tets each, or what -dm_plex_filename names
     -metric uniform | isotropic | layer    the metric; wrong ones:
             parts | negative | global      differs where parts meet; is none on rank 0; is a global vector
     -h H         wanted size                 -overlap N   layers of tets that ranks have twice
     -distribute 0   all stays on the first rank
     -bd NAME     label of the boundary       -regions     a label with two regions, and the faces between them
     -marked LAST label `bd` is made on the parts: LAST where those of a rank end, 1 to LAST - 1 at z = 1/2 by who is below
     -rounds N    adaptations, one after another
     -values      the values that each rank has of the label of the boundary
     -checks      PETSc's checks of the result, and the coordinates and owners of what ranks share */
#include <petscdmplex.h>
#include <petscsf.h>

typedef struct {
  char      metric[32], bd[64];
  PetscReal h;
  PetscInt  cells, overlap, rounds, marked;
  PetscBool regions, checks, has_bd, distribute, values;
} Options;

static PetscErrorCode get_options(Options *o)
{
  PetscFunctionBeginUser;
  PetscCall(PetscStrcpy(o->metric, "isotropic"));
  o->distribute = PETSC_TRUE;
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-distribute", &o->distribute, NULL));
  o->h       = 0.2;
  o->cells   = 4;
  o->overlap = 0;
  o->rounds  = 1;
  o->marked  = 0;
  o->regions = o->checks = o->has_bd = o->values = PETSC_FALSE;
  PetscCall(PetscOptionsGetString(NULL, NULL, "-metric", o->metric, sizeof o->metric, NULL));
  PetscCall(PetscOptionsGetString(NULL, NULL, "-bd", o->bd, sizeof o->bd, &o->has_bd));
  PetscCall(PetscOptionsGetReal(NULL, NULL, "-h", &o->h, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-cells", &o->cells, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-overlap", &o->overlap, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-rounds", &o->rounds, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-regions", &o->regions, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-checks", &o->checks, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-values", &o->values, NULL));
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-marked", &o->marked, NULL));
  PetscFunctionReturn(0);
}

/* Region 7 is x < 1/2, region 9 the rest; the faces between them join label `bd` with the value 42. */
static PetscErrorCode label_regions(DM dm, const char *bd)
{
  PetscInt c, cells, cells_end, f, faces, faces_end;
  DMLabel  regions;

  PetscFunctionBeginUser;
  PetscCall(DMCreateLabel(dm, "Regions"));
  PetscCall(DMGetLabel(dm, "Regions", &regions));
  PetscCall(DMPlexGetHeightStratum(dm, 0, &cells, &cells_end));
  for (c = cells; c < cells_end; ++c) {
    PetscReal volume, centroid[3];

    PetscCall(DMPlexComputeCellGeometryFVM(dm, c, &volume, centroid, NULL));
    PetscCall(DMLabelSetValue(regions, c, centroid[0] < 0.5 ? 7 : 9));
  }
  PetscCall(DMPlexGetHeightStratum(dm, 1, &faces, &faces_end));
  for (f = faces; f < faces_end && bd; ++f) {
    PetscInt        size, a, b;
    const PetscInt *support;

    PetscCall(DMPlexGetSupportSize(dm, f, &size));
    PetscCall(DMPlexGetSupport(dm, f, &support));
    if (size != 2) continue;
    PetscCall(DMLabelGetValue(regions, support[0], &a));
    PetscCall(DMLabelGetValue(regions, support[1], &b));
    if (a != b) PetscCall(DMSetLabelValue(dm, bd, f, 42));
  }
  PetscFunctionReturn(0);
}

/* The unit cube on the first rank: PETSc makes no boxes of tets without TetGen, which Debian's is without. */
static PetscErrorCode create_cube(PetscInt n, DM *dm)
{
  static const PetscInt paths[6][2] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
  PetscMPIInt           rank;
  PetscInt              i, j, k, p, d, m = n + 1, step[3], tets = 0, points = 0, *cells;
  PetscReal            *x;

  PetscFunctionBeginUser;
  step[0] = 1;
  step[1] = m;
  step[2] = m * m;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(PetscMalloc2(24 * n * n * n, &cells, 3 * m * m * m, &x));
  for (k = 0; k < m && !rank; ++k)
    for (j = 0; j < m; ++j)
      for (i = 0; i < m; ++i, ++points) {
        x[3 * points]     = (PetscReal)i / n;
        x[3 * points + 1] = (PetscReal)j / n;
        x[3 * points + 2] = (PetscReal)k / n;
        for (p = 0; p < 6 && i < n && j < n && k < n; ++p, ++tets) {
          PetscInt *tet = cells + 4 * tets;

          tet[0] = points;
          tet[1] = tet[0] + step[paths[p][0]];
          tet[2] = tet[1] + step[paths[p][1]];
          tet[3] = points + step[0] + step[1] + step[2];
          if (p == 0 || p == 3 || p == 4) { /* even permutations of the axes */
            d      = tet[0];
            tet[0] = tet[1];
            tet[1] = d;
          }
        }
      }
  PetscCall(DMPlexCreateFromCellListPetsc(PETSC_COMM_WORLD, 3, tets, points, 4, PETSC_TRUE, cells, 3, x, dm));
  PetscCall(PetscFree2(cells, x));
  PetscFunctionReturn(0);
}

/* As PETSc labels its boxes: "marker" is 1 on the whole boundary, vertices and edges too; "Face Sets" numbers sides. */
static PetscErrorCode label_cube(DM dm)
{
  DMLabel  marker;
  PetscInt f, faces, faces_end, d;

  PetscFunctionBeginUser;
  PetscCall(DMCreateLabel(dm, "marker"));
  PetscCall(DMGetLabel(dm, "marker", &marker));
  PetscCall(DMPlexMarkBoundaryFaces(dm, 1, marker));
  PetscCall(DMPlexGetHeightStratum(dm, 1, &faces, &faces_end));
  for (f = faces; f < faces_end; ++f) {
    PetscReal area, c[3];

    PetscCall(DMPlexComputeCellGeometryFVM(dm, f, &area, c, NULL));
    for (d = 0; d < 3; ++d) {
      if (c[d] < 1e-9) PetscCall(DMSetLabelValue(dm, "Face Sets", f, 1 + 2 * d));
      if (c[d] > 1 - 1e-9) PetscCall(DMSetLabelValue(dm, "Face Sets", f, 2 + 2 * d));
    }
  }
  PetscCall(DMPlexLabelComplete(dm, marker));
  PetscFunctionReturn(0);
}

/* As PETSc's ex60 labels what it has distributed: faces between ranks have all values where z = 1/2. */
static PetscErrorCode mark_parts(DM dm, const char *bd, PetscInt last)
{
  DMLabel  label;
  PetscInt f, faces, faces_end, size, value;

  PetscFunctionBeginUser;
  PetscCall(DMCreateLabel(dm, bd));
  PetscCall(DMGetLabel(dm, bd, &label));
  PetscCall(DMPlexMarkBoundaryFaces(dm, last, label));
  PetscCall(DMPlexGetHeightStratum(dm, 1, &faces, &faces_end));
  for (f = faces; f < faces_end; ++f) {
    const PetscInt *support;
    PetscReal       measure, face[3], cell[3];

    PetscCall(DMPlexComputeCellGeometryFVM(dm, f, &measure, face, NULL));
    if (PetscAbsReal(face[2] - 0.5) > 1e-9) continue;
    PetscCall(DMPlexGetSupportSize(dm, f, &size));
    PetscCall(DMPlexGetSupport(dm, f, &support));
    while (size-- > 0) {
      PetscCall(DMPlexComputeCellGeometryFVM(dm, support[size], &measure, cell, NULL));
      if (cell[2] > 0.5) continue;
      for (value = 1; value < last; ++value) PetscCall(DMLabelSetValue(label, f, value));
    }
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode create_mesh(const Options *o, DM *dm)
{
  DM distributed = NULL;

  PetscFunctionBeginUser;
  if (o->cells > 0) {
    PetscCall(create_cube(o->cells, dm));
    PetscCall(label_cube(*dm));
  } else {
    PetscCall(DMCreate(PETSC_COMM_WORLD, dm));
    PetscCall(DMSetType(*dm, DMPLEX));
  }
  PetscCall(DMPlexDistributeSetDefault(*dm, PETSC_FALSE)); /* labels are made on the whole mesh, then distributed */
  PetscCall(DMSetFromOptions(*dm));
  if (o->regions) PetscCall(label_regions(*dm, o->has_bd ? o->bd : NULL));
  if (o->distribute) PetscCall(DMPlexDistribute(*dm, o->overlap, NULL, &distributed));
  if (distributed) {
    PetscCall(DMDestroy(dm));
    *dm = distributed;
  }
  if (o->marked > 0) PetscCall(mark_parts(*dm, o->bd, o->marked));
  PetscFunctionReturn(0);
}

/* The wanted size across x: small at x = 1/2. */
static PetscReal layer(const Options *o, PetscReal x) { return PetscMin(o->h, 0.03 + 0.5 * PetscAbsReal(x - 0.5)); }

static PetscErrorCode fill_tensors(DM dm, const Options *o, Vec metric)
{
  DM                 coordinate_dm;
  Vec                coordinates;
  const PetscScalar *points;
  PetscScalar       *tensors;
  PetscInt           v, vertices, vertices_end, i;
  PetscMPIInt        rank;
  PetscBool          along_x, differs, negative;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(PetscStrcmp(o->metric, "layer", &along_x));
  PetscCall(PetscStrcmp(o->metric, "parts", &differs));
  PetscCall(PetscStrcmp(o->metric, "negative", &negative));
  PetscCall(DMGetCoordinateDM(dm, &coordinate_dm));
  PetscCall(DMGetCoordinatesLocal(dm, &coordinates));
  PetscCall(VecGetArrayRead(coordinates, &points));
  PetscCall(VecGetArray(metric, &tensors));
  PetscCall(DMPlexGetDepthStratum(dm, 0, &vertices, &vertices_end));
  for (v = vertices; v < vertices_end; ++v) {
    PetscScalar *m = tensors + 9 * (v - vertices), *x;
    PetscReal    h;

    PetscCall(DMPlexPointLocalRead(coordinate_dm, v, points, &x));
    h = differs ? o->h * (1 + 0.001 * rank) : o->h;
    for (i = 0; i < 9; ++i) m[i] = i % 4 == 0 ? 1 / (h * h) : 0;
    if (along_x) m[0] = 1 / PetscSqr(layer(o, PetscRealPart(x[0])));
    if (negative && rank == 0) m[4] = -1;
  }
  PetscCall(VecRestoreArray(metric, &tensors));
  PetscCall(VecRestoreArrayRead(coordinates, &points));
  PetscFunctionReturn(0);
}

static PetscErrorCode create_metric(DM dm, const Options *o, Vec *metric)
{
  PetscBool uniform, isotropic, global;

  PetscFunctionBeginUser;
  PetscCall(PetscStrcmp(o->metric, "uniform", &uniform));
  PetscCall(PetscStrcmp(o->metric, "isotropic", &isotropic));
  PetscCall(PetscStrcmp(o->metric, "global", &global));
  if (uniform) {
    PetscCall(DMPlexMetricCreateUniform(dm, 0, 1 / (o->h * o->h), metric));
  } else if (isotropic) {
    PetscCall(DMPlexMetricSetIsotropic(dm, PETSC_TRUE));
    PetscCall(DMPlexMetricCreate(dm, 0, metric));
    PetscCall(VecSet(*metric, 1 / (o->h * o->h)));
  } else if (global) { /* not what DMAdaptMetric() takes */
    PetscCall(VecCreateMPI(PETSC_COMM_WORLD, 17, PETSC_DECIDE, metric));
  } else {
    PetscCall(DMPlexMetricCreate(dm, 0, metric));
    PetscCall(fill_tensors(dm, o, *metric));
  }
  PetscFunctionReturn(0);
}

/* Which points other ranks own. */
static PetscErrorCode mark_foreign(DM dm, char **foreign)
{
  PetscSF         sf;
  PetscInt        i, start, end, roots, leaves;
  const PetscInt *points;

  PetscFunctionBeginUser;
  PetscCall(DMPlexGetChart(dm, &start, &end));
  PetscCall(PetscCalloc1(end, foreign));
  PetscCall(DMGetPointSF(dm, &sf));
  PetscCall(PetscSFGetGraph(sf, &roots, &leaves, &points, NULL));
  for (i = 0; roots >= 0 && i < leaves; ++i) (*foreign)[points ? points[i] : i] = 1;
  PetscFunctionReturn(0);
}

/* The number and the measure of the points that a label has with a value, each point counted by its owner. */
static PetscErrorCode tell_stratum(DM dm, const char *foreign, const char *name, PetscInt value, PetscInt height)
{
  DMLabel         label;
  IS              is;
  PetscInt        i, n = 0, start, end;
  const PetscInt *points = NULL;
  double          mine[2] = {0, 0}, all[2];

  PetscFunctionBeginUser;
  PetscCall(DMPlexGetHeightStratum(dm, height, &start, &end));
  PetscCall(DMGetLabel(dm, name, &label));
  PetscCall(DMLabelGetStratumIS(label, value, &is));
  if (is) {
    PetscCall(ISGetLocalSize(is, &n));
    PetscCall(ISGetIndices(is, &points));
  }
  for (i = 0; i < n; ++i) {
    PetscReal measure, centroid[3];

    if (points[i] < start || points[i] >= end || foreign[points[i]]) continue;
    PetscCall(DMPlexComputeCellGeometryFVM(dm, points[i], &measure, centroid, NULL));
    mine[0] += 1;
    mine[1] += (double)measure;
  }
  if (is) PetscCall(ISRestoreIndices(is, &points));
  PetscCall(ISDestroy(&is));
  PetscCallMPI(MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "label %s %d: %d of %.9f\n", name, (int)value, (int)all[0], all[1]));
  PetscFunctionReturn(0);
}

static PetscErrorCode tell_label(DM dm, const char *foreign, const char *name, PetscInt height)
{
  DMLabel  label;
  PetscInt value;

  PetscFunctionBeginUser;
  PetscCall(DMGetLabel(dm, name, &label));
  if (!label) PetscCall(PetscPrintf(PETSC_COMM_WORLD, "no label %s\n", name));
  for (value = 0; label && value < 50; ++value) {
    PetscBool   has;
    PetscMPIInt mine, any;

    PetscCall(DMLabelHasStratum(label, value, &has));
    mine = has;
    PetscCallMPI(MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_LOR, PETSC_COMM_WORLD));
    if (any) PetscCall(tell_stratum(dm, foreign, name, value, height));
  }
  PetscFunctionReturn(0);
}

static PetscErrorCode tell_values(DM dm, const char *name)
{
  DMLabel         label;
  IS              is;
  PetscInt        i, n;
  const PetscInt *values;
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(DMGetLabel(dm, name, &label));
  PetscCall(DMLabelGetValueIS(label, &is));
  PetscCall(ISGetLocalSize(is, &n));
  PetscCall(ISGetIndices(is, &values));
  PetscCall(PetscSynchronizedPrintf(PETSC_COMM_WORLD, "values on rank %d:", (int)rank));
  for (i = 0; i < n; ++i) PetscCall(PetscSynchronizedPrintf(PETSC_COMM_WORLD, " %d", (int)values[i]));
  PetscCall(PetscSynchronizedPrintf(PETSC_COMM_WORLD, "\n"));
  PetscCall(PetscSynchronizedFlush(PETSC_COMM_WORLD, PETSC_STDOUT));
  PetscCall(ISRestoreIndices(is, &values));
  PetscCall(ISDestroy(&is));
  PetscFunctionReturn(0);
}

static PetscErrorCode tell_sizes(DM dm, const char *foreign)
{
  PetscInt           k, p, start, end;
  long               counts[4] = {0, 0, 0, 0}, all[4], most[2], fewest[2];
  double             volume = 0, whole, least = 1e300, least_of_all;
  PetscReal          one, centroid[3];

  PetscFunctionBeginUser;
  for (k = 0; k < 4; ++k) {
    PetscCall(DMPlexGetDepthStratum(dm, k, &start, &end));
    for (p = start; p < end; ++p) counts[k] += !foreign[p];
  }
  PetscCall(DMPlexGetHeightStratum(dm, 0, &start, &end));
  for (p = start; p < end; ++p) {
    if (foreign[p]) continue;
    PetscCall(DMPlexComputeCellGeometryFVM(dm, p, &one, centroid, NULL));
    volume += (double)one;
    least = PetscMin(least, (double)one);
  }
  PetscCallMPI(MPI_Allreduce(counts, all, 4, MPI_LONG, MPI_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(&volume, &whole, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Allreduce(&least, &least_of_all, 1, MPI_DOUBLE, MPI_MIN, PETSC_COMM_WORLD));
  most[0] = counts[3];
  PetscCallMPI(MPI_Allreduce(most, most + 1, 1, MPI_LONG, MPI_MAX, PETSC_COMM_WORLD));
  fewest[0] = counts[3];
  PetscCallMPI(MPI_Allreduce(fewest, fewest + 1, 1, MPI_LONG, MPI_MIN, PETSC_COMM_WORLD));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "mesh: %ld vertices, %ld edges, %ld faces, %ld cells\n", all[0], all[1], all[2], all[3]));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "volume: %.12f, least %s\n", whole, least_of_all > 0 ? "positive" : "not positive"));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "cells of a rank: %ld to %ld\n", fewest[1], most[1]));
  PetscFunctionReturn(0);
}

/* What ranks share is the same point for both: the owner's coordinates arrive where the rank has its own. */
static PetscErrorCode check_shared(DM dm)
{
  DM        coordinate_dm;
  Vec       local, global, again;
  PetscReal difference, worst;
  PetscSF   sf;

  PetscFunctionBeginUser;
  PetscCall(DMPlexCheck(dm));
  PetscCall(DMPlexCheckGeometry(dm));
  PetscCall(DMGetPointSF(dm, &sf));
  PetscCall(DMPlexCheckPointSF(dm, sf, PETSC_FALSE));
  PetscCall(DMGetCoordinateDM(dm, &coordinate_dm));
  PetscCall(DMGetCoordinatesLocal(dm, &local));
  PetscCall(DMGetCoordinates(dm, &global));
  PetscCall(VecDuplicate(local, &again));
  PetscCall(DMGlobalToLocal(coordinate_dm, global, INSERT_VALUES, again));
  PetscCall(VecAXPY(again, -1, local));
  PetscCall(VecNorm(again, NORM_INFINITY, &difference));
  PetscCallMPI(MPI_Allreduce(&difference, &worst, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscCall(VecDestroy(&again));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "checked: shared vertices differ by %g\n", (double)worst));
  PetscFunctionReturn(0);
}

static PetscErrorCode tell(DM dm, const Options *o)
{
  char *foreign;

  PetscFunctionBeginUser;
  PetscCall(DMGetCoordinatesLocalSetUp(dm));
  PetscCall(mark_foreign(dm, &foreign));
  PetscCall(tell_sizes(dm, foreign));
  if (o->has_bd) PetscCall(tell_label(dm, foreign, o->bd, 1));
  if (o->regions) PetscCall(tell_label(dm, foreign, "Regions", 0));
  if (o->values) PetscCall(tell_values(dm, o->bd));
  PetscCall(PetscFree(foreign));
  if (o->checks) PetscCall(check_shared(dm));
  PetscFunctionReturn(0);
}

static PetscErrorCode adapt(const Options *o, DM *dm)
{
  DM      adapted;
  Vec     metric;
  DMLabel bd = NULL, regions = NULL;

  PetscFunctionBeginUser;
  PetscCall(create_metric(*dm, o, &metric));
  if (o->has_bd) PetscCall(DMGetLabel(*dm, o->bd, &bd));
  if (o->regions) PetscCall(DMGetLabel(*dm, "Regions", &regions));
  PetscCall(DMAdaptMetric(*dm, metric, bd, regions, &adapted));
  PetscCall(VecDestroy(&metric));
  PetscCall(DMDestroy(dm));
  *dm = adapted;
  PetscFunctionReturn(0);
}

int main(int argc, char **argv)
{
  DM       dm;
  Options  o;
  PetscInt round;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(get_options(&o));
  PetscCall(create_mesh(&o, &dm));
  PetscCall(tell(dm, &o));
  for (round = 0; round < o.rounds; ++round) {
    PetscCall(adapt(&o, &dm));
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "adapted:\n"));
    PetscCall(tell(dm, &o));
  }
  PetscCall(DMDestroy(&dm));
  return PetscFinalize();
}
