// Better neighbourhoods for the worst tets.
#pragma once

#include "meshing/initial/recovery/recovery.h"

namespace weft::meshing {

/// Gives the worst tets better neighbourhoods, with added points or without those that are.
void improve_tets(Recovery& r);

}  // namespace weft::meshing
