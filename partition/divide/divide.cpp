// Chooses a part for each tet; hand_over() does the rest.
#include "partition/divide/divide.h"

#include <algorithm>
#include <numeric>

#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/tet_tables.h"
#include "partition/coordinate/boundary_coordinate.h"
#include "partition/decompose/decomposition.h"
#include "partition/decompose/tet_measures.h"
#include "partition/divide/pieces_of_parts.h"
#include "partition/shift/hand_over.h"

namespace weft::partition {

using meshing::TetId;
using meshing::TetMesh;
using meshing::VertexId;

namespace {

/// The tets that are alive, as the partitioners take them.
struct LiveTets {
  std::vector<TetId> ids;
  std::vector<std::array<std::uint32_t, 4>> vertices;
  TetMeasures measures;
};

LiveTets live_tets(const TetMesh& mesh) {
  LiveTets live;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    if (!mesh.alive(TetId(i))) continue;
    const meshing::TetVertices v = mesh.vertices(TetId(i));
    live.ids.emplace_back(i);
    live.vertices.push_back({v[0].value, v[1].value, v[2].value, v[3].value});
    const TetCorners corners{mesh.point(v[0]), mesh.point(v[1]), mesh.point(v[2]), mesh.point(v[3])};
    const std::array<meshing::LogMetric, 4> log_metrics{mesh.log_metric(v[0]), mesh.log_metric(v[1]),
                                                        mesh.log_metric(v[2]), mesh.log_metric(v[3])};
    live.measures.add(corners, log_metrics, expected_complexity(corners, log_metrics));
  }
  return live;
}

/// The subdomain's mesh as a share that is all of it; boundary faces have the references of their patches.
MeshSlice as_slice(const TetMesh& mesh, const LiveTets& live, const meshing::Surface& surface) {
  MeshSlice slice;
  std::vector<std::uint32_t> places(mesh.vertex_slots(), meshing::kNoNeighbour);
  for (std::size_t k = 0; k < live.ids.size(); ++k) {
    auto& tet = slice.tets.emplace_back(live.vertices[k]);
    for (std::uint32_t& v : tet) {
      if (places[v] == meshing::kNoNeighbour) {
        places[v] = static_cast<std::uint32_t>(slice.points.size());
        slice.points.push_back(mesh.point(VertexId(v)));
      }
      v = places[v];
    }
    for (int f = 0; f < 4; ++f) {
      const meshing::PatchId patch = mesh.patch(live.ids[k], f);
      if (!patch.valid()) continue;
      const auto& corners = meshing::kTetFaces[static_cast<std::size_t>(f)];
      slice.boundary.triangles.push_back({tet[corners[0]], tet[corners[1]], tet[corners[2]]});
      slice.boundary.triangle_refs.push_back(surface.patches()[patch.value].ref);
    }
  }
  slice.num_points = slice.points.size();
  slice.num_tets = slice.tets.size();
  slice.num_triangles = slice.boundary.triangles.size();
  slice.point_refs.resize(slice.points.size());
  slice.tet_refs.resize(slice.tets.size());
  return slice;
}

/// How far each tet reaches along the partitioner's coordinate.
std::vector<double> reaches(const TetMesh& mesh, const LiveTets& live, const meshing::Surface& surface,
                            const BoundaryCoordinate& coordinate) {
  SelfPeers alone;
  const MeshSlice slice = as_slice(mesh, live, surface);
  const std::vector<double> values = boundary_coordinate(alone, slice, coordinate).values;
  std::vector<double> reach;
  for (const auto& [a, b, c, d] : slice.tets)
    reach.push_back(std::max({values[a], values[b], values[c], values[d]}));
  return reach;
}

/// By place in `live`; the mesh is whole here, so nobody is asked.
Decomposition parts_of(const TetMesh& mesh, const LiveTets& live, const DivisionOptions& options,
                       const meshing::Surface* surface) {
  const TetMeasures& m = live.measures;
  std::vector<double> work(live.ids.size(), 1);
  if (!options.equal_tets) work = m.work();
  std::vector<std::uint64_t> numbers(live.ids.size());
  std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
  std::vector<double> along;
  if (const BoundaryCoordinate& c = options.partitioner.coordinate; c.asked() && surface)
    along = reaches(mesh, live, *surface, c);
  SelfPeers alone;
  return decompose(alone,
                   {m.centres, m.corners, work, numbers, m.cut_tensors, live.vertices, m.face_areas,
                    m.complexities, along},
                   options.num_parts, options.partitioner);
}

struct ChosenParts {
  Chosen chosen;
  std::vector<std::vector<std::uint64_t>> pieces;  ///< of the background, by part; empty: not known
  std::string warning;                             ///< what is to be said of the parts
};

/// The subdomain keeps the first part.
ChosenParts choose_parts(const Subdomain& s, const DivisionOptions& options, const meshing::Surface* surface,
                         const ReceiverOrder& order) {
  ChosenParts result;
  result.pieces.resize(options.num_parts);
  Chosen& chosen = result.chosen;
  chosen.to.assign(s.mesh->tet_slots(), kNobody);
  if (options.num_parts == 1 || options.keeps_all) return result;
  const LiveTets live = live_tets(*s.mesh);
  if (live.ids.empty()) return result;
  Decomposition decomposition = parts_of(*s.mesh, live, options, surface);
  const std::vector<SubdomainId>& parts = decomposition.subdomains;
  result.warning = std::move(decomposition.warning);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].value == 0) continue;
    chosen.to[live.ids[k].value] = order.place_of(SubdomainId(s.id.value + parts[k].value));
    chosen.leaving.push_back(live.ids[k]);
  }
  result.pieces = pieces_of_parts(s, live.vertices, parts, options.num_parts);
  return result;
}

}  // namespace

Divided divide(Subdomain& s, const DivisionOptions& options, const meshing::Surface* surface) {
  s.departures.clear();
  s.frozen_since.clear();
  std::vector<Priority> parts;
  for (std::uint32_t p = 1; p < options.num_parts; ++p) parts.push_back({0, SubdomainId(s.id.value + p)});
  const ReceiverOrder order({0, s.id}, parts);
  const ChosenParts chosen = choose_parts(s, options, surface, order);
  std::vector<Receiver> receivers;
  for (const SubdomainId neighbour : s.interface.neighbours()) receivers.push_back({neighbour, {}, {}, {}});
  for (std::uint32_t p = 1; p < options.num_parts; ++p)
    receivers.push_back({parts[p - 1].id, {}, {}, chosen.pieces[p]});
  std::ranges::sort(receivers, {}, &Receiver::id);
  Divided result;
  result.warning = chosen.warning;
  std::vector<Parcel> parcels = hand_over(s, order, chosen.chosen, receivers);
  for (std::size_t i = 0; i < parcels.size(); ++i)
    result.parcels.push_back({receivers[i].id, std::move(parcels[i])});
  return result;
}

double predicted_tets(const Subdomain& s) {
  const std::vector<double> work = live_tets(*s.mesh).measures.work();
  return std::accumulate(work.begin(), work.end(), 0.0);
}

}  // namespace weft::partition
