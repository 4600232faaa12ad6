// The readable account of a run or of a mesh's measures; nothing wider than 100 columns unless a path is.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "meshing/metric/measures.h"
#include "tools/weft/jobs/adapt_run.h"

namespace weft::tools {

/// A column of measures under its title; a null pointer leaves the column to dashes.
using MeasuresColumn = std::pair<std::string, const meshing::Measures*>;
std::string measures_table(const std::vector<MeasuresColumn>& columns);

/// One line, without its end.
std::string shape_text(const meshing::ShapeMeasures& shape);

/// Bars of a histogram, one line a bin.
std::string histogram_text(const std::string& title, const meshing::Histogram& histogram);

std::string summary_text(const RunResult& run);

}  // namespace weft::tools
