// A triangle cut in its plane: a constrained triangulation of exact points. For sources that name CGAL.
#pragma once

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <array>
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

namespace weft::meshing {

using ExactKernel = CGAL::Exact_predicates_exact_constructions_kernel;

/// Grows from one triangle by points and segments within it. Nearly Delaunay where no segment is in the way.
class PlaneTriangulation {
 public:
  using Point2 = ExactKernel::Point_2;
  using Face = std::array<std::uint32_t, 3>;
  /// Gives a name to the point where two segments of this triangle cross: (a, b) and (c, d).
  using NameCrossing = std::function<std::uint32_t(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                                   std::uint32_t d, Point2& where)>;

  /// Corners in positive order, named by the caller's numbers.
  PlaneTriangulation(const Face& corners, const std::array<Point2, 3>& places);

  void insert(std::uint32_t vertex, const Point2& place);
  /// Both ends must have been inserted. Where it crosses another segment both get a new vertex.
  void insert_segment(std::uint32_t a, std::uint32_t b, const NameCrossing& name);
  const std::vector<Face>& faces() const { return faces_; }

 private:
  static std::uint64_t directed(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }
  static std::uint64_t undirected(std::uint32_t a, std::uint32_t b) {
    return a < b ? directed(a, b) : directed(b, a);
  }
  bool is_beyond(std::uint32_t a, std::uint32_t b, std::uint32_t vertex) const;
  bool holds(const Face& f, std::uint32_t vertex) const;
  std::size_t locate(std::uint32_t vertex) const;
  std::size_t walk_to(std::uint32_t vertex) const;
  int orient(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  void set_face(std::size_t i, const Face& f);
  void add_face(const Face& f);
  bool has_edge(std::uint32_t a, std::uint32_t b) const {
    return face_at_.contains(directed(a, b)) || face_at_.contains(directed(b, a));
  }
  std::uint32_t apex(std::uint32_t a, std::uint32_t b) const;  ///< of the face left of a -> b
  void split_edge(std::uint32_t a, std::uint32_t b, std::uint32_t vertex);
  void flip(std::uint32_t a, std::uint32_t b);
  void improve();
  bool worth_flipping(std::uint32_t a, std::uint32_t b) const;
  bool force(std::uint32_t a, std::uint32_t b, const NameCrossing& name);
  /// What a -> b meets first beyond a: a vertex on it (second = kNone), or an edge.
  std::array<std::uint32_t, 2> first_beyond(std::uint32_t a, std::uint32_t b) const;
  std::array<std::uint32_t, 2> meets_in(std::size_t face, std::uint32_t a, std::uint32_t b) const;

  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::vector<Face> faces_;
  std::unordered_map<std::uint64_t, std::size_t> face_at_;  ///< directed edge -> the face that it bounds
  std::unordered_map<std::uint32_t, std::size_t> face_of_;  ///< of each vertex: one that holds it
  std::size_t last_ = 0;                                    ///< where the last vertex was inserted
  std::unordered_map<std::uint32_t, Point2> place_;
  std::unordered_map<std::uint32_t, std::array<double, 2>> rounded_;
  std::unordered_map<std::uint64_t, bool> fixed_;
  std::vector<std::uint64_t> suspects_;
  double size_ = 0;  ///< the largest coordinate
};

}  // namespace weft::meshing
