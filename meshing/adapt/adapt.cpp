// The shared-memory kernel on one mesh in memory: checks, background, adaptation, and back to plain arrays.
#include "meshing/adapt/adapt.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "meshing/adapt/stages.h"
#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/base/spare_address_space.h"
#include "meshing/kernel/import_mesh.h"
#include "meshing/kernel/on_model.h"
#include "meshing/metric/measure_again.h"
#include "meshing/metric/measures.h"
#include "meshing/operators/surface_fit.h"

namespace weft::meshing {
namespace {

using Clock = std::chrono::steady_clock;

/// Of address space, for lists and scratch of the passes.
constexpr std::size_t kForPasses = std::size_t{64} << 20;

/// Bytes of the result's arrays.
std::size_t result_bytes(double vertices, double tets) {
  constexpr double kOfVertex = sizeof(Point) + sizeof(std::int32_t) + sizeof(LogMetric);
  constexpr double kOfTet = 4 * sizeof(std::uint32_t) + sizeof(std::int32_t), kMore = 1.3;  // boundary, error
  return static_cast<std::size_t>(kMore * (kOfVertex * vertices + kOfTet * tets));
}

/// Address space for many times the predicted size: holes and a mesh that must first grow cost slots.
std::size_t capacity(double predicted, std::size_t input) {
  return static_cast<std::size_t>(
      std::min(double{kMostTets}, 10 * predicted + 4 * static_cast<double>(input) + 1e6));
}

void check_background(const BackgroundData& background) {
  if (!background.mesh || !background.log_metrics) throw InputError("", "metric", "none is given");
  check_arrays(*background.mesh);
  if (background.mesh->tets.empty()) throw InputError("", "Tetrahedra", "the mesh has none");
  if (background.log_metrics->size() != background.mesh->points.size())
    throw InputError("", "metric", "has another number of vertices than its mesh");
  for (std::size_t i = 0; i < background.log_metrics->size(); ++i) {
    const LogMetric& l = (*background.log_metrics)[i];
    if (!std::isfinite(l.xx + l.xy + l.yy + l.xz + l.yz + l.zz))
      throw InputError("", "metric of vertex " + std::to_string(i + 1), "is not finite");
  }
}

/// AdaptResult::origins. Slots may have been taken again, so that what is in them is compared.
std::vector<std::uint32_t> origins_of(const TetMesh& mesh, const MeshData& input,
                                      const LogMetricField& log_metrics) {
  const auto points = static_cast<std::uint32_t>(input.points.size());
  const auto tets = static_cast<std::uint32_t>(input.tets.size());
  std::vector<std::uint8_t> same(mesh.vertex_slots(), 0);
  for (std::uint32_t i = 0; i < std::min(mesh.vertex_slots(), points); ++i)
    same[i] = mesh.alive(VertexId(i)) && mesh.point(VertexId(i)) == input.points[i] &&
              mesh.log_metric(VertexId(i)) == log_metrics[i];
  std::vector<std::uint32_t> origins;
  origins.reserve(mesh.tet_slots());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    if (!mesh.alive(TetId(i))) continue;
    const TetVertices v = mesh.vertices(TetId(i));
    const std::array<std::uint32_t, 4> tet{v[0].value, v[1].value, v[2].value, v[3].value};
    const bool is_same =
        i < tets && tet == input.tets[i] && same[tet[0]] && same[tet[1]] && same[tet[2]] && same[tet[3]];
    origins.push_back(is_same ? i : kNoOrigin);
  }
  return origins;
}

/// The mesh of a state takes the place of the input; boundary and background are the input's.
void go_on_with(TetMeshArrays arrays, ImportedMesh& imported) {
  const std::size_t vertices = std::max(imported.mesh->vertex_capacity(), arrays.points.size());
  const std::size_t tets = std::max(imported.mesh->tet_capacity(), arrays.tets.size());
  imported.mesh.reset();
  imported.mesh = from_arrays(arrays, vertices, tets, Pages::huge);
}

}  // namespace

AdaptResult adapt(const MeshData& input, const BackgroundData& given, const AdaptOptions& asked) {
  const auto start = Clock::now();
  check_background(given);
  AdaptOptions options = asked;
  const int threads = std::max(1, options.threads);
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] {
    AdaptResult result;
    if (!(options.complexity > 0)) options.complexity = complexity(*given.mesh, *given.log_metrics);
    const double expected = options.complexity;
    SpareAddressSpace for_result(
        result_bytes(kVerticesPerComplexity * expected, kTetsPerComplexity * expected));
    SpareAddressSpace for_passes(kForPasses);
    ImportedMesh imported = import_mesh(
        input, options.ridge_angle_degrees, capacity(kVerticesPerComplexity * expected, input.points.size()),
        capacity(kTetsPerComplexity * expected, input.tets.size()), options.model);
    result.report.warnings = std::move(imported.warnings);
    for_passes.release();
    {
      const bool same = given.mesh == &input;
      const Background background(*given.mesh, *given.log_metrics,
                                  same ? std::move(imported.adjacency)
                                       : build_adjacency(given.mesh->tets, given.mesh->points.size()));
      if (options.resume)
        go_on_with(std::move(options.resume->mesh), imported);
      else
        read_metric(*imported.mesh, background, same);
      Kernel kernel{*imported.mesh, background, *imported.surface, {}};
      kernel.limits.hausd =
          options.hausd > 0 ? options.hausd : kHausdOfDiagonal * norm(box_of(input.points).size());
      if (options.hausd == 0) kernel.limits.details = 1;
      adapt_in_place(kernel, options, Extent::everything, result.report);
      for_result.release();
      result.report.surface_deviation = largest_surface_deviation(*imported.mesh, *imported.surface);
      result.report.hausd = kernel.limits.hausd;
      result.report.surface_demands = surface_demands(kernel);
      if (options.model) {
        ModelAccount account = account_on_model(*imported.mesh, *imported.surface);
        account.input = imported.on_model;
        std::uint32_t count;
        const std::vector<std::uint32_t> places = places_of_vertices(*imported.mesh, count);
        for (std::uint32_t& v : account.listed) v = places[v];
        result.report.model = std::make_shared<const ModelAccount>(std::move(account));
      }
    }
    if (result.report.in_order && given.mesh == &input)
      result.origins = origins_of(*imported.mesh, input, *given.log_metrics);
    export_mesh(*imported.mesh, *imported.surface, imported.patch_required, result.mesh, result.log_metrics);
    if (options.model) {
      result.mesh.association.model = input.association.model;
      result.mesh.association.model_in_words = input.association.model_in_words;
    }
    result.report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return result;
  });
}

}  // namespace weft::meshing
