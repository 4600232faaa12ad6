// What one rank finds wrong must stop all of them: else the others wait for it for ever.
#pragma once

#include <petscsys.h>

#include <string>

namespace weft::petsc {

/// All ranks: fails on all of them with the text of the lowest rank whose `issue` is not empty.
PetscErrorCode agree(MPI_Comm comm, PetscErrorCode code, const std::string& issue);

}  // namespace weft::petsc
