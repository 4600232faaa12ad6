// Whether all ranks compute alike: holders of an interface must come to the same decisions from the same
// numbers without a word between them.
#pragma once

#include <cstdint>

#include "partition/communication/peers.h"

namespace weft::partition {

/// A hash of the bits of exp, log, cbrt, sqrt, pow and of the kernel's metric functions on fixed inputs.
/// Another C library, or another variant that it chooses for another processor, gives another hash.
std::uint64_t arithmetic_fingerprint();

/// All ranks: throws meshing::InputError naming two ranks whose fingerprints differ.
void check_same_arithmetic(Peers& peers, std::uint64_t mine = arithmetic_fingerprint());

}  // namespace weft::partition
