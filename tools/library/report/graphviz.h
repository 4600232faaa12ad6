// Graphviz as another program.
#pragma once

#include <string>

namespace weft::tools {

/// The picture of a graph in Graphviz's language. Throws InputError when `dot` is not installed or fails.
std::string svg_of(const std::string& dot);

}  // namespace weft::tools
