#include "tools/bindings/petsc/plex_options.h"

#include <string>

namespace weft::petsc {
namespace {

// What PETSc says where the user has said nothing; these are Mmg's defaults. Weft has its own.
constexpr PetscReal kGradationUnsaid = 1.3, kHausdorffUnsaid = 0.01;
constexpr PetscInt kIterationsUnsaid = 3;

/// Whether the user has given an option, on the command line or by a call that changed its value.
template <class Value>
PetscErrorCode is_said(DM dm, const char* option, Value value, Value unsaid, bool& said) {
  const char* prefix = nullptr;
  PetscOptions database = nullptr;
  PetscBool given = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(PetscObjectGetOptionsPrefix(reinterpret_cast<PetscObject>(dm), &prefix));
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(dm), &database));
  PetscCall(PetscOptionsHasName(database, prefix, option, &given));
  said = given || value != unsaid;
  PetscFunctionReturn(0);
}

PetscErrorCode allowed_operations(DM dm, PlexOptions& options) {
  PetscBool insertion = PETSC_FALSE, swapping = PETSC_FALSE, movement = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(DMPlexMetricNoInsertion(dm, &insertion));
  PetscCall(DMPlexMetricNoSwapping(dm, &swapping));
  PetscCall(DMPlexMetricNoMovement(dm, &movement));
  options.weft.allowed = {!insertion, !swapping, !movement};
  PetscFunctionReturn(0);
}

PetscErrorCode metric_options(DM dm, PlexOptions& options) {
  PetscReal gradation = 0, hausdorff = 0;
  PetscInt iterations = 0;
  PetscBool no_surf = PETSC_FALSE;
  bool said = false;
  PetscFunctionBegin;
  PetscCall(DMPlexMetricGetGradationFactor(dm, &gradation));
  PetscCall(is_said(dm, "-dm_plex_metric_gradation_factor", gradation, kGradationUnsaid, said));
  if (said) options.weft.metric.hgrad = gradation > 1 ? gradation : 0;
  PetscCall(DMPlexMetricGetHausdorffNumber(dm, &hausdorff));
  PetscCall(is_said(dm, "-dm_plex_metric_hausdorff_number", hausdorff, kHausdorffUnsaid, said));
  if (said) options.weft.geometry.hausd = hausdorff;
  PetscCall(DMPlexMetricGetNumIterations(dm, &iterations));
  PetscCall(is_said(dm, "-dm_plex_metric_num_iterations", iterations, kIterationsUnsaid, said));
  if (said) options.weft.distributed.shifts = static_cast<std::uint32_t>(iterations);
  PetscCall(DMPlexMetricNoSurf(dm, &no_surf));
  options.boundary_stays = no_surf;
  PetscCall(DMPlexMetricGetVerbosity(dm, &options.verbosity));
  PetscFunctionReturn(0);
}

PetscErrorCode own_options(DM dm, PlexOptions& options) {
  PetscFunctionBegin;
  PetscInt threads = 1, subdomains = 0;
  const char* prefix = nullptr;
  PetscCall(PetscObjectGetOptionsPrefix(reinterpret_cast<PetscObject>(dm), &prefix));
  PetscOptionsBegin(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), prefix, "Adaptation by weft",
                    nullptr);
  PetscCall(PetscOptionsBoundedInt("-weft_threads", "Threads of a rank; with 1 the result is repeatable", "",
                                   threads, &threads, nullptr, 1));
  PetscCall(PetscOptionsBoundedInt("-weft_subdomains",
                                   "Subdomains of all ranks together; 0: 4 for each thread", "", subdomains,
                                   &subdomains, nullptr, 0));
  PetscOptionsEnd();
  options.weft.run.threads = static_cast<int>(threads);
  options.weft.distributed.subdomains = static_cast<std::uint32_t>(subdomains);
  PetscFunctionReturn(0);
}

}  // namespace

PetscErrorCode options_of_plex(DM dm, PlexOptions& options) {
  PetscFunctionBegin;
  PetscCall(allowed_operations(dm, options));
  PetscCall(metric_options(dm, options));
  PetscCall(own_options(dm, options));
  PetscFunctionReturn(0);
}

}  // namespace weft::petsc
