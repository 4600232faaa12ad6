// How large an adapted mesh is expected to be: what plans, weights and predictions go by.
#pragma once

namespace weft::meshing {

/// Tets and vertices of an adapted mesh for each unit of complexity (a unit of volume in the metric): 10 to
/// 12 tets. Work is predicted by the higher number; whether a mesh has more tets than it needs, by the lower.
inline constexpr double kTetsPerComplexity = 12;
inline constexpr double kFewestTetsPerComplexity = 10;
inline constexpr double kVerticesPerComplexity = 2;

}  // namespace weft::meshing
