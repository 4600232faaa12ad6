// A mesh, or its fields, that rank 0 reads and deals out to all ranks while it does: no rank ever holds it
// whole.
#pragma once

#include <string>

#include "partition/communication/peers.h"
#include "tools/library/jobs/sources/shares.h"

namespace weft::tools {

/// All ranks: the share of a file that meshing::can_be_streamed(). Blocks of rows go round the
/// ranks as they are read; when their numbers are known, each rank gets its share of what all have got. Rank
/// 0 holds what the others do, a block, and few lists (points that are elements, records on a CAD model).
/// Throws InputError alike on all ranks.
MeshShare read_dealt_share(partition::Peers& peers, const std::string& file, meshing::OtherVolumes others);

/// All ranks: the fields of a file that meshing::can_stream_fields(), at the points of its shares; none where
/// it has none. Rows go to the ranks that have their points, as they are read. Throws InputError alike on all
/// ranks.
FieldsShare read_dealt_fields(partition::Peers& peers, const std::string& file);

}  // namespace weft::tools
