// The adaptor that PETSc calls: a DMPlex and a metric in, an adapted DMPlex out.
#include <petscdmplex.h>

#include <exception>
#include <string>

#include "tools/bindings/petsc/agreement.h"
#include "tools/bindings/petsc/include/weft_petsc.h"
#include "tools/bindings/petsc/plex_input.h"
#include "tools/bindings/petsc/plex_options.h"
#include "tools/bindings/petsc/plex_output.h"
#include "weft/weft.h"

namespace weft::petsc {
namespace {

PetscErrorCode check_label_names(MPI_Comm comm, DMLabel bd_label, DMLabel rg_label) {
  PetscFunctionBegin;
  if (bd_label && rg_label) {
    const char *bd = nullptr, *rg = nullptr;
    PetscCall(PetscObjectGetName(reinterpret_cast<PetscObject>(bd_label), &bd));
    PetscCall(PetscObjectGetName(reinterpret_cast<PetscObject>(rg_label), &rg));
    PetscCheck(std::string(bd) != rg, comm, PETSC_ERR_ARG_WRONG,
               "one label, \"%s\", cannot be that of the boundary and that of the regions", bd);
  }
  PetscFunctionReturn(0);
}

/// All ranks: weft throws alike on all of them, so all return the same error.
PetscErrorCode run(MPI_Comm comm, const PlexInput& input, const Options& options, PartResult& result) {
  std::string issue;
  PetscErrorCode code = PETSC_ERR_LIB;
  PetscFunctionBegin;
  try {
    result = adapt(comm, input.part, input.metric, options);
  } catch (const InputError& error) {
    issue = error.what();
    code = PETSC_ERR_ARG_WRONG;
  } catch (const OptionError& error) {
    issue = error.what();
    code = PETSC_ERR_ARG_OUTOFRANGE;
  } catch (const std::exception& error) {
    issue = error.what();
  }
  PetscCheck(issue.empty(), comm, code, "weft: %s", issue.c_str());
  PetscFunctionReturn(0);
}

PetscErrorCode tell(MPI_Comm comm, DM dm, PetscInt verbosity, const PartResult& result) {
  PetscMPIInt rank = 0;
  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  const std::string text = rank == 0 ? summary(result) : std::string();
  if (verbosity >= 1) PetscCall(PetscPrintf(comm, "%s\n", text.c_str()));
  for (const std::string& warning : result.warnings) PetscCall(PetscInfo(dm, "weft: %s\n", warning.c_str()));
  for (const std::string& missed : result.missed) PetscCall(PetscInfo(dm, "weft: %s\n", missed.c_str()));
  PetscFunctionReturn(0);
}

PetscErrorCode adapt_plex(DM dm, Vec metric, DMLabel bd_label, DMLabel rg_label, DM* adapted) {
  PetscFunctionBegin;
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  PlexOptions options;
  PlexInput input;
  PartResult result;
  PetscCall(check_label_names(comm, bd_label, rg_label));
  PetscCall(options_of_plex(dm, options));
  PetscCall(read_plex(dm, metric, bd_label, rg_label, input));
  if (options.boundary_stays) require_boundary(input.part.mesh);
  PetscCall(run(comm, input, options.weft, result));
  input.part = {};
  input.metric = {};
  PetscCall(tell(comm, dm, options.verbosity, result));
  PetscCall(make_plex(dm, result.part, bd_label, input.faces, rg_label, input.regions, adapted));
  PetscFunctionReturn(0);
}

/// PETSc's stack of calls knows no C++: nothing may be thrown through it.
PetscErrorCode adapt_metric(DM dm, Vec metric, DMLabel bd_label, DMLabel rg_label, DM* adapted) {
  std::string issue;
  PetscFunctionBegin;
  try {
    PetscCall(adapt_plex(dm, metric, bd_label, rg_label, adapted));
  } catch (const std::exception& error) {
    issue = error.what();
  }
  PetscCheck(issue.empty(), PETSC_COMM_SELF, PETSC_ERR_LIB, "weft: %s", issue.c_str());
  PetscFunctionReturn(0);
}

}  // namespace
}  // namespace weft::petsc

PETSC_EXTERN PetscErrorCode WeftRegisterDMAdaptor(void) {
  PetscFunctionBegin;
  PetscCall(DMInitializePackage());  // which would clear the list of adaptors if it came later
  PetscCall(DMGenerateRegister("weft", nullptr, nullptr, weft::petsc::adapt_metric, -1));
  PetscFunctionReturn(0);
}

/// What PETSc calls in a library that -dll_append names: after the name of the file, libweft_petsc.so. (A
/// file libweft-petsc.so would ask for a function with a hyphen in its name.)
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_weft_petsc(void) {
  PetscFunctionBegin;
  PetscCall(WeftRegisterDMAdaptor());
  PetscFunctionReturn(0);
}
