// The values that a label of PETSc has at a point, as one reference, and back.
#pragma once

#include <petscdmplex.h>

#include <cstdint>
#include <map>
#include <vector>

namespace weft::petsc {

/// What references stand for where that is more than one value: a set of two and more values that points have
/// on any rank gets a reference that is no value of the label, the same on all ranks. One value alone is its
/// own reference, none the label's default.
using LabelSets = std::map<std::int32_t, std::vector<PetscInt>>;

/// All ranks: the references of the points from `start` to `end`. A point that ranks share has the values
/// that it has on any of them. A label that is null gives `none` to all points.
PetscErrorCode references_of(DM dm, DMLabel label, PetscInt start, PetscInt end, PetscInt none,
                             std::vector<std::int32_t>& refs, LabelSets& sets);

/// The values that a reference stands for.
std::vector<PetscInt> values_of(const LabelSets& sets, std::int32_t ref);

/// All ranks: the numbers that any rank has, sorted, each once.
PetscErrorCode gather_values(MPI_Comm comm, const std::vector<PetscInt>& mine, std::vector<PetscInt>& all);

/// All ranks: of each point, what `op` makes of the numbers that ranks have for it. `values`: of the chart.
PetscErrorCode combine_shared(DM dm, MPI_Op op, std::vector<PetscInt>& values);

}  // namespace weft::petsc
