// In shares; of a patch with one side one rank builds the whole surface.
#include "partition/surface/surface_parts.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/geometry/model/model_classification.h"
#include "meshing/geometry/surface/surface_tables.h"
#include "partition/communication/agreement.h"
#include "partition/surface/surface_shares.h"
#include "partition/surface/vertex_flags.h"

namespace weft::partition {
namespace {

using meshing::MeshData;

/// The boundary on one rank.
struct WholeBoundary {
  MeshData data;                       ///< numbered by entries of `numbers`
  std::vector<std::uint32_t> numbers;  ///< of data.points in the whole input, ascending
};

/// All ranks: what they have, to the last.
template <class T>
std::vector<T> sent_to_last(Peers& peers, std::vector<T> mine) {
  std::vector<std::vector<T>> to_each(static_cast<std::size_t>(peers.ranks()));
  to_each.back() = std::move(mine);
  return all_to_all_joined(peers, std::move(to_each));
}

void take_triangles(std::vector<BoundaryTriangle> triangles, MeshData& data) {
  std::ranges::sort(triangles, {}, &BoundaryTriangle::number);
  for (const BoundaryTriangle& t : triangles) {
    if (t.required) data.required_triangles.push_back(t.number);
    data.triangles.push_back(t.vertices);
    data.triangle_refs.push_back(t.ref);
  }
}

void take_edges(std::vector<BoundaryEdge> edges, MeshData& data) {
  std::ranges::sort(edges, {}, &BoundaryEdge::vertices);
  for (const BoundaryEdge& e : edges) {
    if (e.required) data.required_edges.push_back(static_cast<std::uint32_t>(data.edges.size()));
    data.edges.push_back(e.vertices);
    data.edge_refs.push_back(e.ref);
  }
}

/// Renumbers the records of vertices on the boundary, and forgets the others.
template <class Record>
void renumber_records(const std::vector<std::uint32_t>& numbers, std::vector<Record>& records) {
  std::erase_if(records, [&](const Record& r) { return !std::ranges::binary_search(numbers, r.vertex); });
  for (Record& r : records) r.vertex = static_cast<std::uint32_t>(meshing::place_in(numbers, r.vertex));
}

/// Renumbers by the points that occur, in their order.
void compress(WholeBoundary& b) {
  MeshData& d = b.data;
  for (const auto& t : d.triangles) b.numbers.insert(b.numbers.end(), t.begin(), t.end());
  for (const auto* list : {&d.corners, &d.required_points})
    b.numbers.insert(b.numbers.end(), list->begin(), list->end());
  meshing::sort_unique(b.numbers);
  const auto renumber = [&](std::span<std::uint32_t> vertices) {
    for (std::uint32_t& v : vertices) v = static_cast<std::uint32_t>(meshing::place_in(b.numbers, v));
  };
  for (auto& t : d.triangles) renumber(t);
  for (auto& e : d.edges) renumber(e);
  renumber(d.corners);
  renumber(d.required_points);
  renumber_records(b.numbers, d.association.nodes);
  renumber_records(b.numbers, d.association.edges);
  renumber_records(b.numbers, d.association.faces);
}

/// All ranks: all of it on the last; elsewhere nothing.
WholeBoundary gathered(Peers& peers, BoundaryShare&& share, const FetchPoints& points) {
  WholeBoundary whole;
  take_triangles(sent_to_last(peers, std::exchange(share.triangles, {})), whole.data);
  take_edges(sent_to_last(peers, std::exchange(share.edges, {})), whole.data);
  whole.data.association.nodes = sent_to_last(peers, std::move(share.on_model.nodes));
  whole.data.association.edges = sent_to_last(peers, std::move(share.on_model.edges));
  whole.data.association.faces = sent_to_last(peers, std::move(share.on_model.faces));
  if (peers.rank() + 1 == peers.ranks()) {
    whole.data.corners = std::move(share.corners);
    whole.data.required_points = std::move(share.required_points);
  }
  compress(whole);
  whole.data.points = points(whole.numbers);
  return whole;
}

BoundaryRecords records_of(const WholeBoundary& boundary, const meshing::BuiltSurface& surface) {
  BoundaryRecords records;
  const auto number = [&](std::uint32_t v) { return boundary.numbers[v]; };
  const std::vector<std::uint8_t> flags = vertex_flags(boundary.data, surface.input.vertex_kind,
                                                       surface.input.triangle_patch, surface.tables->patches);
  for (std::uint32_t v = 0; v < flags.size(); ++v)
    records.vertices.push_back(
        {number(v), surface.input.vertex_hint[v], surface.input.vertex_kind[v], flags[v]});
  for (std::uint32_t t = 0; t < boundary.data.triangles.size(); ++t) {
    const auto& [a, b, c] = boundary.data.triangles[t];
    records.faces.push_back({{number(a), number(b), number(c)}, surface.input.triangle_patch[t]});
    std::ranges::sort(records.faces.back().vertices);
  }
  for (const auto& feature : surface.input.features)
    records.edges.push_back({{number(feature.vertices[0]), number(feature.vertices[1])}, feature.curve});
  return records;
}

/// What the rank that builds tells the others.
struct Told {
  std::vector<std::byte> tables;
  std::vector<char> warnings;          ///< each ended by 0
  std::vector<std::uint8_t> required;  ///< by patch
  std::vector<std::uint64_t> triangles;
  std::vector<meshing::ModelFaults> faults;  ///< one: of the input on its model
};

SurfaceParts build_here(const WholeBoundary& boundary, double ridge_angle_degrees,
                        const std::shared_ptr<const meshing::Model>& model, Told& told) {
  meshing::ModelClassification on_model;
  if (model) on_model = meshing::classify_on_model(boundary.data, model);
  for (const std::string& warning : on_model.warnings)
    told.warnings.insert(told.warnings.end(), warning.c_str(), warning.c_str() + warning.size() + 1);
  told.faults = {on_model.faults};
  meshing::BuiltSurface surface =
      meshing::build_surface(boundary.data, {ridge_angle_degrees}, std::move(on_model), boundary.numbers);
  told.tables = bytes_of(*surface.tables);
  told.required.resize(surface.tables->patches.size());
  for (const std::uint32_t t : boundary.data.required_triangles)
    told.required[surface.input.triangle_patch[t].value] = 1;
  told.triangles.resize(told.required.size());
  for (const meshing::PatchId patch : surface.input.triangle_patch) ++told.triangles[patch.value];
  SurfaceParts parts;
  parts.records = records_of(boundary, surface);
  parts.cutter = std::move(surface.cutter);
  return parts;
}

template <class T>
void tell(Peers& peers, std::vector<T>& values) {
  values = std::move(allgather(peers, values).back());
}

SurfaceParts build_on_one(Peers& peers, BoundaryShare&& boundary, const FetchPoints& points,
                          double ridge_angle_degrees, const std::shared_ptr<const meshing::Model>& model,
                          std::vector<std::string>& warnings) {
  // The cutter refers to the points: they must not move from here on.
  const auto kept = std::make_shared<WholeBoundary>(gathered(peers, std::move(boundary), points));
  SurfaceParts parts;
  Told told;
  agree_on(peers, [&] {
    if (peers.rank() + 1 == peers.ranks()) parts = build_here(*kept, ridge_angle_degrees, model, told);
  });
  parts.mesh = {kept, &kept->data};
  tell(peers, told.tables), tell(peers, told.warnings), tell(peers, told.required),
      tell(peers, told.triangles), tell(peers, told.faults);
  for (auto at = told.warnings.begin(); at != told.warnings.end();) {
    const auto end = std::find(at, told.warnings.end(), '\0');
    warnings.emplace_back(at, end);
    at = end + 1;
  }
  parts.geometry =
      std::make_shared<Geometry>(Geometry{meshing::Surface(meshing::tables_of(told.tables, model)),
                                          {told.required.begin(), told.required.end()},
                                          std::vector<bool>(told.required.size(), false),
                                          told.faults.front()});
  parts.triangles = std::move(told.triangles);
  return parts;
}

}  // namespace

SurfaceParts build_surface_parts(Peers& peers, BoundaryShare&& boundary, const FetchPoints& points,
                                 double ridge_angle_degrees,
                                 const std::shared_ptr<const meshing::Model>& model,
                                 std::vector<std::string>& warnings) {
  if (auto parts = build_surface_in_shares(peers, boundary, points, ridge_angle_degrees, model, warnings))
    return std::move(*parts);
  return build_on_one(peers, std::move(boundary), points, ridge_angle_degrees, model, warnings);
}

}  // namespace weft::partition
