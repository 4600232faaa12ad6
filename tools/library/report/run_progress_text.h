// How far a run in subdomains is, as a sentence.
#pragma once

#include <string>

#include "graph/adaptation/progress.h"

namespace weft::tools {

/// "shift 2 of at most 8: 100 of 128 subdomains, ...": what a run in subdomains has done, what remains, and
/// how long it takes, as far as that can be told.
std::string text_of(const graph::adaptation::RunProgress& progress);

}  // namespace weft::tools
