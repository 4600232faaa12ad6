// All that can be measured of a mesh, and its JSON.
#include "engine/json/json.h"
#include "tools/library/report/report_json.h"
#include "weft/weft.h"

namespace weft {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::map<std::int32_t, double>& by_ref) {
  Json all = Json::object();
  for (const auto& [ref, value] : by_ref) all[std::to_string(ref)] = value;
  return all;
}

Json json_of(const ShapeMeasures& shape) {
  return {{"quality",
           {{"mean", shape.quality_mean}, {"min", shape.quality_min}, {"quantile_0.01", shape.quality_q01}}},
          {"least_dihedral_degrees", shape.least_dihedral_degrees}};
}

}  // namespace

MeshFigures measure_all(const Mesh& mesh, const Metric* metric, const GeometryOptions& geometry,
                        const std::string& name, int threads) {
  MeshFigures figures;
  figures.counts = {mesh.points.size(), mesh.tets.size(), mesh.triangles.size(), mesh.edges.size()};
  figures.corners = mesh.corners.size();
  figures.ridges = mesh.ridges.size();
  figures.required_vertices = mesh.required_points.size();
  figures.required_edges = mesh.required_edges.size();
  figures.required_triangles = mesh.required_triangles.size();
  figures.geometry = measure_geometry(mesh);
  if (metric) figures.measures = measure(mesh, *metric);
  if (!geometry.model.empty())
    figures.model = measure_on_model(mesh, geometry, name, threads, nullptr, &figures.model_warnings);
  return figures;
}

std::string to_json(const MeshFigures& figures) {
  const MeshCounts& counts = figures.counts;
  const Geometry& g = figures.geometry;
  Json json = {{"schema", "weft-stat-1"},
               {"version", version()},
               {"vertices", counts.vertices},
               {"tets", counts.tets},
               {"triangles", counts.triangles},
               {"edges", counts.edges},
               {"corners", figures.corners},
               {"ridges", figures.ridges},
               {"required",
                {{"vertices", figures.required_vertices},
                 {"edges", figures.required_edges},
                 {"triangles", figures.required_triangles}}},
               {"shape", json_of(g.shape)},
               {"bounding_box", {{g.min.x, g.min.y, g.min.z}, {g.max.x, g.max.y, g.max.z}}},
               {"volume_by_ref", json_of(g.volume_by_ref)},
               {"area_by_ref", json_of(g.area_by_ref)}};
  if (figures.measures) json["measures"] = Json::parse(to_json(*figures.measures));
  if (figures.model) json["model"] = Json::parse(to_json(*figures.model));
  if (figures.model) json["model"]["warnings"] = figures.model_warnings;
  return tools::text_of(json, 1);
}

}  // namespace weft
