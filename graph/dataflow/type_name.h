// Names of types as a reader writes them.
#pragma once

#include <string>
#include <typeinfo>

namespace weft::graph::dataflow {

/// "std::vector<double>" of what the compiler calls "St6vectorIdSaIdEE".
std::string type_name(const std::type_info& type);

template <class T>
std::string type_name() {
  return type_name(typeid(T));
}

}  // namespace weft::graph::dataflow
