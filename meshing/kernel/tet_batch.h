// Quality and edge lengths of tets of the mesh, eight at a time: what an adaptation looks at first of all.
#pragma once

#include <array>
#include <cstdint>

#include "meshing/base/lanes.h"
#include "meshing/kernel/tet_mesh.h"

namespace weft::meshing {

/// What is seen of a tet.
struct SeenTet {
  TetId tet;
  TetVertices vertices;
  double quality = 0;            ///< judge_quality() in the arithmetic mean, within 1e-12
  std::uint8_t short_edges = 0;  ///< bit e: kTetEdges[e] is below the one bound
  bool has_long_edge = false;    ///< one is above the other
};

/// Up to kLanes tets of a mesh.
class TetBatch {
 public:
  TetBatch(const TetMesh& mesh, double short_edge, double long_edge)
      : mesh_(mesh), short_edge_(short_edge), long_edge_(long_edge) {}

  void add(TetId t);
  bool full() const { return size_ == kLanes; }
  /// Calls visit(SeenTet) for each, in their order; the batch is empty then.
  template <class Visit>
  void take(const Visit& visit) {
    if (size_ > 0) look();
    for (int i = 0; i < size_; ++i) visit(seen_[static_cast<std::size_t>(i)]);
    size_ = 0;
  }

 private:
  using Row = std::array<double, kLanes>;

  void look();
  void look_at_edges();
  void look_at_qualities();
  VecLanes edge(std::size_t a, std::size_t b) const;

  const TetMesh& mesh_;
  const double short_edge_, long_edge_;
  int size_ = 0;
  std::array<SeenTet, kLanes> seen_;
  // By corner. What is left over from earlier tets is reckoned with and not read.
  alignas(64) std::array<std::array<Row, 3>, 4> points_{};
  alignas(64) std::array<std::array<Row, 6>, 4> metrics_{};
};

}  // namespace weft::meshing
