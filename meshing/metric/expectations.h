// What is known beforehand of an adapted mesh, in one place: for predictions, for limits, for reports.
#pragma once

namespace weft::meshing {

/// Tets of a mesh that conforms, for each unit of complexity, about. What is compared with tet counts that
/// have been reached uses this one.
inline constexpr double kTetsOfUnitVolume = 10;
/// The same with what comes on top in most cases (boundary layers of tets, poor metrics): for room, memory
/// and predictions of time, where too much is better than too little.
inline constexpr double kTetsPerComplexity = 12;
/// Vertices, likewise.
inline constexpr double kVerticesPerComplexity = 2;

/// Tets worse than this are counted as not conforming in reports.
inline constexpr double kPoorQuality = 0.4;
/// In a mesh that is good as a whole only worse tets are worth looking at.
inline constexpr double kFair = 0.6;
/// A poor tet's neighbourhood is worth being moved between subdomains.
inline constexpr double kShiftBelow = 0.5;
/// A mesh of whose tets more than this share is poor does not fit its metric: what is wrong is everywhere.
inline constexpr double kMisfitShare = 0.2;
/// Tets worse than this are repaired one by one at the end, judged by the exact measure. There are so few
/// that it costs no more time than 0.4; in subdomains it is what the minimum rests upon (delta-wing to
/// 300,000 in 96: 0.50 instead of 0.45).
inline constexpr double kRepairBelow = 0.55;

/// The largest deviation from the reference surface that is allowed by default, as a share of the diagonal of
/// the bounding box.
inline constexpr double kHausdOfDiagonal = 0.001;

}  // namespace weft::meshing
