// Numbering of the reference tet: faces and edges by local vertices. All orders keep orientation.
#pragma once

#include <array>

namespace weft::meshing {

/// Face i lies opposite vertex i; (face, i) is an even permutation, so i is on the face's positive side.
inline constexpr std::array<std::array<int, 3>, 4> kTetFaces = {{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};
/// Edge e joins kTetEdges[e][0] and [1]; the opposite edge is [2],[3]; all four form an even permutation.
inline constexpr std::array<std::array<int, 4>, 6> kTetEdges = {
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};
/// The edge between two different local vertices.
inline constexpr std::array<std::array<int, 4>, 4> kEdgeOf = {
    {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}}};

}  // namespace weft::meshing
