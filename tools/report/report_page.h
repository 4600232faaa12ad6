// The report as one HTML page that needs nothing beside itself.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace weft::report {

/// `profile`: of schema "weft-profile-1". The page has Chart.js and three.js inside, asks no network for
/// anything (its own policy forbids it), and shows what the document has. Throws std::invalid_argument for
/// another schema.
std::string report_page(const nlohmann::ordered_json& profile);

/// The page of `weft report A B`; `comparison`: comparison_json() of compare.h.
std::string comparison_page(const nlohmann::ordered_json& comparison);

}  // namespace weft::report
