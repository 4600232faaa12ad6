// The memory that freed blobs leave behind for the next ones.
#pragma once

namespace weft::engine {

/// Gives it back to the system. After messages whose like does not come again.
void give_back_freed_blobs();

}  // namespace weft::engine
