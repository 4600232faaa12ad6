#include "tools/bindings/petsc/plex_output.h"

#include <petscsf.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <unordered_map>
#include <vector>

namespace weft::petsc {
namespace {

MPI_Comm comm_of(DM dm) { return PetscObjectComm(reinterpret_cast<PetscObject>(dm)); }

/// PETSc wants the vertices of rank 0 first, then those of rank 1, and so on.
struct Numbering {
  std::vector<PetscInt> numbers;  ///< of all points of the part
  PetscInt owned = 0;             ///< by this rank
};

/// All ranks: the owner of a point numbers it; all others that have it are told.
PetscErrorCode number_by_owner(MPI_Comm comm, const Part& part, Numbering& numbering) {
  PetscMPIInt rank = 0;
  PetscInt end = 0, total = 0;
  PetscLayout layout = nullptr;
  PetscSF sf = nullptr;
  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  for (const int owner : part.owners) numbering.owned += owner == rank;
  PetscCallMPI(MPI_Scan(&numbering.owned, &end, 1, MPIU_INT, MPI_SUM, comm));
  PetscCallMPI(MPI_Allreduce(&numbering.owned, &total, 1, MPIU_INT, MPI_SUM, comm));
  PetscInt next = end - numbering.owned;
  std::vector<PetscInt> mine;
  for (const int owner : part.owners) mine.push_back(owner == rank ? next++ : -1);
  const std::vector<PetscInt> ids(part.ids.begin(), part.ids.end());
  PetscCall(PetscLayoutCreate(comm, &layout));
  PetscCall(PetscLayoutSetSize(layout, total));
  PetscCall(PetscLayoutSetUp(layout));
  PetscCall(PetscSFCreate(comm, &sf));
  PetscCall(PetscSFSetGraphLayout(sf, layout, static_cast<PetscInt>(ids.size()), nullptr, PETSC_COPY_VALUES,
                                  ids.data()));
  PetscInt homes = 0;
  PetscCall(PetscLayoutGetLocalSize(layout, &homes));
  std::vector<PetscInt> at_home(static_cast<std::size_t>(homes), -1);
  numbering.numbers.resize(ids.size());
  PetscCall(PetscSFReduceBegin(sf, MPIU_INT, mine.data(), at_home.data(), MPI_MAX));
  PetscCall(PetscSFReduceEnd(sf, MPIU_INT, mine.data(), at_home.data(), MPI_MAX));
  PetscCall(PetscSFBcastBegin(sf, MPIU_INT, at_home.data(), numbering.numbers.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(sf, MPIU_INT, at_home.data(), numbering.numbers.data(), MPI_REPLACE));
  PetscCall(PetscSFDestroy(&sf));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscFunctionReturn(0);
}

/// All ranks: makes the mesh; `vertices` gets the vertex of the plex that each number stands for here.
PetscErrorCode make_mesh(DM old, const Part& part, const Numbering& numbering,
                         std::unordered_map<PetscInt, PetscInt>& vertices, DM* made) {
  PetscMPIInt rank = 0;
  PetscInt *adjacent = nullptr, start = 0, end = 0;
  PetscSF vertex_sf = nullptr;
  PetscFunctionBegin;
  MPI_Comm comm = comm_of(old);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  std::vector<PetscReal> coordinates;
  for (std::size_t v = 0; v < part.owners.size(); ++v)
    if (part.owners[v] == rank)
      for (int k = 0; k < 3; ++k) coordinates.push_back(part.mesh.points[v][k]);
  std::vector<PetscInt> cells;
  cells.reserve(4 * part.mesh.tets.size());
  for (const auto& tet : part.mesh.tets)
    for (const int i : {1, 0, 2, 3})  // PETSc's orientation
      cells.push_back(numbering.numbers[tet[static_cast<std::size_t>(i)]]);
  // PETSc 3.18 fills an array that the caller brings; later ones bring their own.
  PetscInt* brought = nullptr;
  PetscCall(PetscMalloc1(part.ids.size(), &brought));
  adjacent = brought;
  PetscCall(DMPlexCreateFromCellListParallelPetsc(comm, 3, static_cast<PetscInt>(part.mesh.tets.size()),
                                                  numbering.owned, PETSC_DECIDE, 4, PETSC_TRUE, cells.data(),
                                                  3, coordinates.data(), &vertex_sf, &adjacent, made));
  PetscCall(PetscSFDestroy(&vertex_sf));
  PetscCall(DMPlexGetDepthStratum(*made, 0, &start, &end));
  for (PetscInt v = start; v < end; ++v) vertices.emplace(adjacent[v - start], v);
  if (adjacent != brought) PetscCall(PetscFree(adjacent));
  PetscCall(PetscFree(brought));
  PetscFunctionReturn(0);
}

/// All ranks: every rank gets all values that any has, in the same order, where it has no such points with an
/// empty stratum: a program that asks a label for its values, or goes through them with collective calls,
/// does the same everywhere.
PetscErrorCode add_values(DM dm, const std::set<std::int32_t>& refs, const LabelSets& sets, PetscInt unset,
                          DMLabel label) {
  PetscFunctionBegin;
  std::vector<PetscInt> mine, all;
  for (const std::int32_t ref : refs)
    for (const PetscInt value : values_of(sets, ref)) mine.push_back(value);
  PetscCall(gather_values(comm_of(dm), mine, all));
  all.erase(std::remove(all.begin(), all.end(), unset), all.end());
  PetscCall(DMLabelAddStrata(label, static_cast<PetscInt>(all.size()), all.data()));
  PetscFunctionReturn(0);
}

/// All ranks: a label of the name and with the default value of `like`, for the values `refs`.
PetscErrorCode create_label(DM dm, DMLabel like, const std::vector<std::int32_t>& refs, const LabelSets& sets,
                            DMLabel* label, PetscInt* unset) {
  const char* name = nullptr;
  PetscFunctionBegin;
  PetscCall(PetscObjectGetName(reinterpret_cast<PetscObject>(like), &name));
  PetscCall(DMCreateLabel(dm, name));
  PetscCall(DMGetLabel(dm, name, label));
  PetscCall(DMLabelGetDefaultValue(like, unset));
  PetscCall(DMLabelSetDefaultValue(*label, *unset));
  PetscCall(add_values(dm, {refs.begin(), refs.end()}, sets, *unset, *label));
  PetscFunctionReturn(0);
}

/// All ranks: whether the label has points of the dimensions below that of faces.
PetscErrorCode labels_corners(DM dm, DMLabel label, bool& any) {
  IS points = nullptr;
  PetscInt faces = 0, faces_end = 0, cells = 0, cells_end = 0;
  PetscMPIInt mine = 0, all = 0;
  PetscFunctionBegin;
  PetscCall(DMPlexGetHeightStratum(dm, 1, &faces, &faces_end));
  PetscCall(DMPlexGetHeightStratum(dm, 0, &cells, &cells_end));
  PetscInt values = 0;
  const PetscInt* of_values = nullptr;
  IS value_set = nullptr;
  PetscCall(DMLabelGetValueIS(label, &value_set));
  PetscCall(ISGetLocalSize(value_set, &values));
  PetscCall(ISGetIndices(value_set, &of_values));
  for (PetscInt i = 0; i < values; ++i) {
    PetscInt size = 0;
    const PetscInt* all_points = nullptr;
    PetscCall(DMLabelGetStratumIS(label, of_values[i], &points));
    if (!points) continue;
    PetscCall(ISGetLocalSize(points, &size));
    PetscCall(ISGetIndices(points, &all_points));
    for (PetscInt p = 0; p < size; ++p)
      mine |= !((all_points[p] >= faces && all_points[p] < faces_end) ||
                (all_points[p] >= cells && all_points[p] < cells_end));
    PetscCall(ISRestoreIndices(points, &all_points));
    PetscCall(ISDestroy(&points));
  }
  PetscCall(ISRestoreIndices(value_set, &of_values));
  PetscCall(ISDestroy(&value_set));
  PetscCallMPI(MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_LOR, comm_of(dm)));
  any = all != 0;
  PetscFunctionReturn(0);
}

/// The faces of the part's triangles get their references. Edges and vertices follow where they did in the
/// old mesh.
PetscErrorCode label_faces(DM old, DMLabel bd_label, const LabelSets& sets, const Part& part,
                           const Numbering& numbering, const std::unordered_map<PetscInt, PetscInt>& vertices,
                           DM made) {
  DMLabel label = nullptr;
  PetscInt unset = -1;
  bool corners = false;
  PetscFunctionBegin;
  PetscCall(create_label(made, bd_label, part.mesh.triangle_refs, sets, &label, &unset));
  for (std::size_t t = 0; t < part.mesh.triangles.size(); ++t) {
    if (part.mesh.triangle_refs[t] == unset) continue;
    std::array<PetscInt, 3> points{};
    for (std::size_t i = 0; i < 3; ++i) points[i] = vertices.at(numbering.numbers[part.mesh.triangles[t][i]]);
    PetscInt count = 0;
    const PetscInt* faces = nullptr;
    PetscCall(DMPlexGetFullJoin(made, 3, points.data(), &count, &faces));
    for (const PetscInt value : values_of(sets, part.mesh.triangle_refs[t]))
      if (count == 1) PetscCall(DMLabelSetValue(label, faces[0], value));
    PetscCall(DMPlexRestoreJoin(made, 3, points.data(), &count, &faces));
  }
  PetscCall(labels_corners(old, bd_label, corners));
  if (corners) PetscCall(DMPlexLabelComplete(made, label));
  PetscFunctionReturn(0);
}

/// The cells of a rank are those of its part, in their order.
PetscErrorCode label_cells(DMLabel rg_label, const LabelSets& sets, const Part& part, DM made) {
  DMLabel label = nullptr;
  PetscInt unset = -1, start = 0, end = 0;
  PetscFunctionBegin;
  PetscCall(create_label(made, rg_label, part.mesh.tet_refs, sets, &label, &unset));
  PetscCall(DMPlexGetHeightStratum(made, 0, &start, &end));
  for (PetscInt c = start; c < end; ++c) {
    const std::int32_t region = part.mesh.tet_refs[static_cast<std::size_t>(c - start)];
    if (region == unset) continue;
    for (const PetscInt value : values_of(sets, region)) PetscCall(DMLabelSetValue(label, c, value));
  }
  PetscFunctionReturn(0);
}

}  // namespace

PetscErrorCode make_plex(DM old, const Part& part, DMLabel bd_label, const LabelSets& faces, DMLabel rg_label,
                         const LabelSets& regions, DM* made) {
  Numbering numbering;
  std::unordered_map<PetscInt, PetscInt> vertices;
  PetscFunctionBegin;
  PetscCall(number_by_owner(comm_of(old), part, numbering));
  PetscCall(make_mesh(old, part, numbering, vertices, made));
  const char* prefix = nullptr;
  PetscCall(PetscObjectGetOptionsPrefix(reinterpret_cast<PetscObject>(old), &prefix));
  PetscCall(PetscObjectSetOptionsPrefix(reinterpret_cast<PetscObject>(*made), prefix));
  if (bd_label) PetscCall(label_faces(old, bd_label, faces, part, numbering, vertices, *made));
  if (rg_label) PetscCall(label_cells(rg_label, regions, part, *made));
  PetscFunctionReturn(0);
}

}  // namespace weft::petsc
