// Triangles of a surface before they are checked: near points, degenerate and repeated triangles are mended.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Triangles that nothing is known of yet, with what goes along with each.
struct LooseTriangles {
  std::vector<Triangle> corners;
  std::vector<std::int32_t> refs;
  std::vector<std::uint32_t> source;  ///< its number in the input
  /// How many sheets it stands for: repeated ones add up when they become one, turned ones subtract.
  std::vector<std::int32_t> sheets;

  std::size_t size() const { return corners.size(); }
  void push_back_piece(std::size_t of, const Triangle& piece);
  /// Takes away those marked; returns their number.
  std::size_t erase(const std::vector<bool>& drop);
};

/// Steps of the mending, in the order in which they are to be called. Points stay; triangles use fewer of
/// them.
class TriangleCleaning {
 public:
  TriangleCleaning(const std::vector<Point>& points, LooseTriangles& triangles, double tolerance)
      : points_(points), triangles_(triangles), tolerance_(tolerance) {}

  static constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
  /// Points nearer than the tolerance are one. Returns how many gave way.
  std::size_t merge_points();
  /// Of each point: what it has become; kUnused for those without triangles.
  const std::vector<std::uint32_t>& merged() const { return merged_; }
  std::size_t drop_collapsed();
  /// A triangle (a, b, c) with c on edge ab gives way: its neighbours beyond ab are split at c. What is
  /// beyond may itself give way (a fan from a cone's tip along a straight line): then who is beyond that is
  /// split at the vertices of both.
  std::size_t mend_degenerate();
  /// Edges, as keys, that mend_degenerate() has split, and the vertex on each.
  const std::unordered_map<std::uint64_t, std::uint32_t>& splits() const { return splits_; }
  std::size_t merge_repeated();
  /// Of triangles that merge_repeated() has dropped: their source, and that of the one that is kept.
  const std::vector<std::array<std::uint32_t, 2>>& repeated() const { return repeated_; }

 private:
  int corner_on_edge(const Triangle& t) const;
  bool is_between(const Triangle& t, int apex) const;
  std::size_t mend_round();
  bool split_at(std::size_t i, const std::unordered_map<std::uint64_t, std::uint32_t>& splits,
                std::vector<bool>& drop);

  const std::vector<Point>& points_;
  LooseTriangles& triangles_;
  double tolerance_;
  std::vector<std::uint32_t> merged_;
  std::unordered_map<std::uint64_t, std::uint32_t> splits_;
  std::vector<std::array<std::uint32_t, 2>> repeated_;
};

/// An edge without direction, as a key.
inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
}

}  // namespace weft::meshing
