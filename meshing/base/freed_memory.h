// What the allocator keeps, given back.
#pragma once

namespace weft::meshing {

/// What has been freed goes back to the system, where the C library can do that: of itself it keeps what lies
/// between blocks that are in use. Takes some milliseconds for 100 MB, and pages that are used again come
/// anew.
void give_back_freed_memory();

}  // namespace weft::meshing
