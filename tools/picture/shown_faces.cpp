// One look at every tet for what a plane leaves of it.
#include "tools/picture/shown_faces.h"

#include <algorithm>

#include "meshing/kernel/import_mesh.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::picture {
namespace {

using meshing::kNoNeighbour;
using meshing::MeshData;

std::array<std::uint32_t, 3> face_of(const MeshData& mesh, std::uint32_t code) {
  const auto& tet = mesh.tets[code / 4];
  std::array<std::uint32_t, 3> face;
  for (std::size_t k = 0; k < 3; ++k)
    face[k] = tet[static_cast<std::size_t>(meshing::kTetFaces[code % 4][k])];
  return face;
}

template <std::size_t kSize>
bool is_behind(const MeshData& mesh, const std::array<std::uint32_t, kSize>& vertices, const Plane& plane) {
  double sum = 0;
  for (const std::uint32_t v : vertices) sum += plane.distance(mesh.points[v]);
  return sum <= 0;
}

/// The section of a tet whose vertices lie in front of the plane or not as `front` says.
Section section_of(const MeshData& mesh, std::uint32_t tet, const std::array<double, 4>& distances) {
  std::array<std::size_t, 4> order;  // those in front, then the others
  std::size_t n = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (distances[i] > 0) order[n++] = i;
  const std::size_t in_front = n;
  for (std::size_t i = 0; i < 4; ++i)
    if (!(distances[i] > 0)) order[n++] = i;
  const auto corner = [&](std::size_t i, std::size_t j) {
    const std::size_t a = order[i], b = order[j];
    return Section::Corner{mesh.tets[tet][a], mesh.tets[tet][b],
                           distances[a] / (distances[a] - distances[b])};
  };
  switch (in_front) {
    case 1:
      return {tet, 3, {corner(0, 1), corner(0, 2), corner(0, 3)}};
    case 3:
      return {tet, 3, {corner(0, 3), corner(1, 3), corner(2, 3)}};
    default:
      return {tet, 4, {corner(0, 2), corner(0, 3), corner(1, 3), corner(1, 2)}};
  }
}

}  // namespace

Surface::Surface(const MeshData& mesh, const std::optional<std::vector<std::int32_t>>& only) : mesh_(mesh) {
  meshing::check_arrays(mesh);
  adjacency_ = meshing::build_adjacency(mesh.tets, mesh.points.size());
  codes_ = meshing::match_triangles(mesh.triangles, mesh.tets, mesh.points.size());
  covered_.resize(4 * mesh.tets.size());
  std::size_t n = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::int32_t ref = mesh.triangle_refs[i];
    if (only && std::ranges::find(*only, ref) == only->end()) continue;
    const std::uint32_t code = codes_[n++] = codes_[i];
    const bool has_tet = code != kNoNeighbour;
    faces_.push_back({mesh.triangles[i], has_tet ? code / 4 : kNoNeighbour, ref, false});
    if (!has_tet) continue;
    covered_[code] = true;
    const std::uint32_t other = adjacency_.neighbours[code / 4][code % 4];
    if (other != kNoNeighbour) covered_[other] = true;
  }
  codes_.resize(n);
  if (!only) add_uncovered();
}

void Surface::add_uncovered() {
  for (std::uint32_t code = 0; code < covered_.size(); ++code)
    if (!covered_[code] && adjacency_.neighbours[code / 4][code % 4] == kNoNeighbour) {
      faces_.push_back({face_of(mesh_, code), code / 4, {}, false});
      codes_.push_back(code);
    }
}

std::vector<ShownFace> Surface::behind(const Plane& plane) const {
  std::vector<bool> kept(mesh_.tets.size());
  for (std::size_t tet = 0; tet < kept.size(); ++tet) kept[tet] = is_behind(mesh_, mesh_.tets[tet], plane);
  const auto is_kept = [&](std::uint32_t code) { return code != kNoNeighbour && kept[code / 4]; };
  std::vector<ShownFace> shown;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    ShownFace face = faces_[i];
    const std::uint32_t code = codes_[i];
    if (code == kNoNeighbour) {
      if (!is_behind(mesh_, face.vertices, plane)) continue;
    } else if (!kept[face.tet]) {
      const std::uint32_t other = adjacency_.neighbours[code / 4][code % 4];
      if (!is_kept(other)) continue;
      face.tet = other / 4;
    }
    shown.push_back(face);
  }
  for (std::uint32_t code = 0; code < covered_.size(); ++code) {
    const std::uint32_t other = adjacency_.neighbours[code / 4][code % 4];
    if (is_kept(code) && other != kNoNeighbour && !is_kept(other) && !covered_[code])
      shown.push_back({face_of(mesh_, code), code / 4, {}, true});
  }
  return shown;
}

std::optional<Section> section(const MeshData& mesh, std::uint32_t tet, const Plane& plane) {
  std::array<double, 4> distances;
  for (std::size_t i = 0; i < 4; ++i) distances[i] = plane.distance(mesh.points[mesh.tets[tet][i]]);
  const auto in_front = std::ranges::count_if(distances, [](double d) { return d > 0; });
  if (in_front == 0 || in_front == 4) return {};
  return section_of(mesh, tet, distances);
}

std::vector<Section> sections(const MeshData& mesh, const Plane& plane) {
  std::vector<Section> all;
  for (std::uint32_t tet = 0; tet < mesh.tets.size(); ++tet)
    if (const auto found = section(mesh, tet, plane)) all.push_back(*found);
  return all;
}

}  // namespace weft::picture
