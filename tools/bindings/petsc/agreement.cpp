#include "tools/bindings/petsc/agreement.h"

#include "weft/weft.h"

namespace weft::petsc {

PetscErrorCode agree(MPI_Comm comm, PetscErrorCode code, const std::string& issue) {
  PetscFunctionBegin;
  const RankError first = first_error(comm, issue);
  PetscCheck(first.rank < 0, comm, code, "weft: rank %d: %s", first.rank, first.text.c_str());
  PetscFunctionReturn(0);
}

}  // namespace weft::petsc
