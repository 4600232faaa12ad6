// Measures of a mesh as text; nothing wider than 100 columns.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "weft/data.h"

namespace weft::tools {

/// A column of measures under its title; a null pointer leaves the column to dashes.
using MeasuresColumn = std::pair<std::string, const Measures*>;
std::string measures_table(const std::vector<MeasuresColumn>& columns);

/// One line, without its end.
std::string shape_text(const ShapeMeasures& shape);

/// Bars of a histogram, one line a bin.
std::string histogram_text(const std::string& title, const Histogram& histogram);

}  // namespace weft::tools
