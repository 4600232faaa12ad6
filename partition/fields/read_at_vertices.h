// Values of one mesh in parts at the vertices of another.
#pragma once

#include "meshing/base/value_table.h"
#include "partition/communication/peers.h"
#include "partition/metric/part_domain.h"

namespace weft::partition {

/// All ranks: values given at the vertices of the part of `of`, read at those of the part of `at` as
/// meshing::interpolate() reads them in the whole mesh: the same bits for any number of ranks. Points go to
/// the ranks that have tets where they lie, and to those farther off while none of these holds them; tets
/// stay where they are. `diameter`: of the box of both meshes. Throws meshing::InputError, on all ranks,
/// where three tets of `of` share a face.
meshing::ValueTable read_at_vertices(Peers& peers, const PartDomain& of, const meshing::ValueTable& values,
                                     const PartDomain& at, double diameter);

}  // namespace weft::partition
