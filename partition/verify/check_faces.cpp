// Sorts the faces of a piece by global ids and walks through the groups of equal ones, beside its triangles.
#include "partition/verify/check_faces.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <sstream>
#include <string>

#include "meshing/mesh/predicates.h"

namespace weft::partition {
namespace {

using meshing::Problems;

/// A face of a tet, or a triangle.
struct Face {
  EntityKey<3> key;
  std::uint32_t entity;
  int side;
};

EntityKey<3> key_of(const MeshPiece& piece, const std::array<std::uint32_t, 3>& vertices) {
  return sorted_key<3>({piece.ids[vertices[0]], piece.ids[vertices[1]], piece.ids[vertices[2]]});
}

/// Whether an odd permutation sorts the ids of three vertices.
bool is_odd(const MeshPiece& piece, const std::array<std::uint32_t, 3>& v) {
  const GlobalId a = piece.ids[v[0]], b = piece.ids[v[1]], c = piece.ids[v[2]];
  return (a > b) ^ (b > c) ^ (a > c);
}

/// The faces of all tets, sorted; reports tets that are not positive.
std::vector<Face> faces_of_tets(const MeshPiece& piece, Problems& problems) {
  constexpr int kFaces[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};  // all seen from the same side
  const auto& p = piece.mesh.points;
  std::vector<Face> faces;
  faces.reserve(4 * piece.mesh.tets.size());
  for (std::uint32_t t = 0; t < piece.mesh.tets.size(); ++t) {
    const auto& v = piece.mesh.tets[t];
    const int sign = meshing::orientation(p[v[0]], p[v[1]], p[v[2]], p[v[3]]);
    if (sign <= 0)
      problems.add("subdomain ", piece.subdomain.value, ": tet ", t + 1, sign < 0 ? ": inverted" : ": flat",
                   " (its orientation is ", sign < 0 ? "negative)" : "zero)");
    for (const auto& f : kFaces) {
      const std::array<std::uint32_t, 3> face{v[f[0]], v[f[1]], v[f[2]]};
      faces.push_back({key_of(piece, face), t, is_odd(piece, face) ? -sign : sign});
    }
  }
  std::ranges::sort(faces, {}, &Face::key);
  return faces;
}

std::vector<Face> sorted_triangles(const MeshPiece& piece, Problems& problems) {
  std::vector<Face> triangles;
  for (std::uint32_t t = 0; t < piece.mesh.triangles.size(); ++t)
    triangles.push_back({key_of(piece, piece.mesh.triangles[t]), t, 0});
  std::ranges::sort(triangles, {}, &Face::key);
  for (std::size_t t = 1; t < triangles.size(); ++t)
    if (triangles[t].key == triangles[t - 1].key)
      problems.add("subdomain ", piece.subdomain.value, ": triangles ", triangles[t - 1].entity + 1, " and ",
                   triangles[t].entity + 1, ": have the same vertices");
  return triangles;
}

template <std::size_t N>
std::string name(const EntityKey<N>& key) {
  std::ostringstream text;
  for (const GlobalId id : key) text << (id == key[0] ? "(" : " ") << id;
  return text.str() + ")";
}

void check_triangles(const MeshPiece& piece, std::span<const Face> faces, std::span<const Face> triangles,
                     Problems& problems) {
  for (const Face& triangle : triangles)
    if (!std::ranges::binary_search(faces, triangle.key, {}, &Face::key))
      problems.add("subdomain ", piece.subdomain.value, ": triangle ", triangle.entity + 1,
                   ": is not a face of any tet");
}

/// A face with several tets in one piece.
void check_inner_face(const MeshPiece& piece, std::span<const Face> tets, bool has_triangle,
                      Problems& problems) {
  if (tets.size() > 2)
    return problems.add("subdomain ", piece.subdomain.value, ": face ", name(tets[0].key), ": shared by ",
                        tets.size(), " tets");
  const std::uint32_t a = tets[0].entity, b = tets[1].entity;
  if (tets[0].side == tets[1].side)
    problems.add("subdomain ", piece.subdomain.value, ": face ", name(tets[0].key), ": tets ", a + 1, " and ",
                 b + 1, " lie on the same side of it");
  if (!has_triangle && piece.mesh.tet_refs[a] != piece.mesh.tet_refs[b])
    problems.add("subdomain ", piece.subdomain.value, ": face ", name(tets[0].key), ": between tets ", a + 1,
                 " and ", b + 1, " of different references without a triangle");
}

void check_two_sides(const OpenFace& a, const OpenFace& b, Problems& problems) {
  const auto add = [&](const char* what) {
    problems.add("face ", name(a.key), " between subdomains ", a.subdomain, " and ", b.subdomain, ": ", what);
  };
  if (a.side == b.side) add("both tets lie on the same side of it");
  if (a.has_triangle != b.has_triangle) add("only one of them has its triangle");
  if (a.has_triangle && b.has_triangle && a.triangle_ref != b.triangle_ref)
    add("its triangle has two references");
  if (!a.has_triangle && !b.has_triangle && a.tet_ref != b.tet_ref)
    add("the tets have different references, but there is no triangle");
}

}  // namespace

std::vector<OpenFace> check_faces(const MeshPiece& piece, Problems& problems) {
  const std::vector<Face> faces = faces_of_tets(piece, problems);
  const std::vector<Face> triangles = sorted_triangles(piece, problems);
  check_triangles(piece, faces, triangles, problems);
  std::vector<OpenFace> open;
  for (std::size_t begin = 0, end; begin < faces.size(); begin = end) {
    for (end = begin + 1; end < faces.size() && faces[end].key == faces[begin].key; ++end) {
    }
    const Face& face = faces[begin];
    const auto triangle = std::ranges::lower_bound(triangles, face.key, {}, &Face::key);
    const bool has_triangle = triangle != triangles.end() && triangle->key == face.key;
    if (end - begin > 1) {
      check_inner_face(piece, {&face, end - begin}, has_triangle, problems);
    } else {
      const std::int32_t ref = has_triangle ? piece.mesh.triangle_refs[triangle->entity] : 0;
      open.push_back({face.key, piece.subdomain.value, face.entity, piece.mesh.tet_refs[face.entity],
                      face.side, ref, has_triangle});
    }
  }
  return open;
}

void check_open_face(const OpenFace* begin, const OpenFace* end, Problems& problems) {
  if (end - begin == 2) return check_two_sides(begin[0], begin[1], problems);
  if (end - begin > 2)
    return problems.add("face ", name(begin->key), ": shared by ", end - begin, " subdomains");
  if (!begin->has_triangle)
    problems.add("subdomain ", begin->subdomain, ": face ", name(begin->key), " of tet ", begin->tet + 1,
                 ": without a triangle and without a tet on its other side");
}

}  // namespace weft::partition
