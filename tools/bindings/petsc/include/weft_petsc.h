/* weft as a mesh adaptor of PETSc: `-dm_adaptor weft` in any program that calls DMAdaptMetric() on a DMPlex.
   Without a change to the program: `-dll_append /path/to/libweft_petsc.so` loads the adaptor. */
#pragma once

#include <petscsys.h>

/* Registers the adaptor "weft". Once after every PetscInitialize(). */
PETSC_EXTERN PetscErrorCode WeftRegisterDMAdaptor(void);
