// What one rank finds wrong must stop all of them: else the others wait for it for ever.
#pragma once

#include <petscsys.h>

#include <string>

namespace weft::petsc {

/// All ranks: fails on all of them with the complaint of the lowest rank that has one; "" is none.
PetscErrorCode agree(MPI_Comm comm, PetscErrorCode code, const std::string& complaint);

}  // namespace weft::petsc
