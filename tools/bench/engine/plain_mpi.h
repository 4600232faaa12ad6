// What MPI does without the engine: the yardstick of transport_bench.
#pragma once

#include <cstddef>

namespace weft::bench {

/// Sends `size` bytes from rank 0 to rank 1 and back, `rounds` times, by MPI_Isend and MPI_Irecv; called by
/// both ranks. What has been received is sent on and the other of the two buffers received into: memory
/// nobody has written to since the last round would be faster to read than any real message. MPI has been
/// initialised. Seconds a round trip takes.
double plain_round_trip(int rank, std::byte* a, std::byte* b, std::size_t size, int rounds);

}  // namespace weft::bench
