// What results and parts have.
#include <utility>

#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"

namespace weft::c {
namespace {

std::shared_ptr<ResultObject> result_of(const weft_result* handle) {
  return object_of<ResultObject>(handle, "result");
}
std::shared_ptr<Part> part_of(const weft_part* handle) { return object_of<PartObject>(handle, "part")->part; }

/// Results of files have left their mesh there.
void require_in_memory(const ResultObject& result) {
  require(!result.files, "result: is one of files, which has its mesh in a file");
}

/// A member of a result, which lives as long as anybody looks at it.
template <class Owner, class Member>
std::shared_ptr<Member> member(const std::shared_ptr<Owner>& owner, Member& of) {
  return {owner, &of};
}

std::shared_ptr<Mesh> mesh_in(const ResultObject& result) {
  require_in_memory(result);
  if (result.filled) return member(result.filled, result.filled->mesh);
  return result.whole ? member(result.whole, result.whole->mesh)
                      : member(result.part, result.part->part.mesh);
}
std::shared_ptr<const Metric> metric_in(const ResultObject& result) {
  require_in_memory(result);
  if (result.filled) return member(result.filled, result.filled->metric);
  return result.whole ? member(result.whole, result.whole->metric) : member(result.part, result.part->metric);
}
std::shared_ptr<Fields> fields_in(const ResultObject& result) {
  require_in_memory(result);
  if (result.whole && !result.whole->fields.fields.empty()) return member(result.whole, result.whole->fields);
  if (result.part && !result.part->part.fields.fields.empty())
    return member(result.part, result.part->part.fields);
  auto none = std::make_shared<Fields>();  // the number of points is that of the mesh all the same
  none->num_points = mesh_in(result)->points.size();
  return none;
}

/// The report of a result, whose mutex the caller holds. A whole mesh that its run has not measured, because
/// it was ended early or told not to, is measured now.
const Report& measured(const ResultObject& result) {
  if (result.whole) weft::measures(*result.whole);
  return result.report();
}

bool was_cancelled(const ResultObject& result) {
  return result.filled ? result.filled->cancelled : result.report().cancelled;
}

bool is_met(const ResultObject& result) {
  return result.filled ? result.filled->missed.empty() : measured(result).goal_met();
}

Measures final_measures(const ResultObject& result) {
  if (result.filled) return weft::measure(result.filled->mesh, result.filled->metric);
  const weft::Report& report = measured(result);
  require(report.after.has_value(), "result: has no measures: the option measure was no");
  return *report.after;
}

/// Writes what a result or a filling, which have members of the same names, has to tell.
template <class Told>
void give_told(const Told& told, weft_told what, weft_text** place) {
  switch (what) {
    case WEFT_WARNINGS:
      return new_lines(told.warnings).give(place);
    case WEFT_MENDS:
      return give_text(place, weft::mends_text(told.mends));
    case WEFT_MISSED:
      return new_lines(told.missed).give(place);
    case WEFT_ENDED_BY:
      return give_text(place, told.ended_by);
  }
  throw Misuse("what: " + std::to_string(static_cast<int>(what)) + " is none of weft_told");
}

weft_measures measures_of(const Measures& m) {
  weft_measures all{};
  all.size = sizeof all;
  all.vertices = static_cast<std::int64_t>(m.num_vertices);
  all.tets = static_cast<std::int64_t>(m.num_tets);
  all.edges = static_cast<std::int64_t>(m.num_edges);
  all.triangles = static_cast<std::int64_t>(m.num_triangles);
  all.volume = m.volume;
  all.complexity = m.complexity;
  all.quality_mean = m.quality_mean;
  all.quality_min = m.quality_min;
  all.quality_q01 = m.quality_q01;
  all.length_mean = m.length_mean;
  all.length_min = m.length_min;
  all.length_max = m.length_max;
  all.edges_unit = m.edges_unit;
  all.edges_short = m.edges_short;
  all.edges_long = m.edges_long;
  return all;
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_result_mesh(const weft_result* result, weft_mesh** mesh) {
  return guarded([&] {
    require_place(mesh, "mesh");
    give_mesh(mesh, mesh_in(*result_of(result)));
  });
}

weft_status weft_result_metric(const weft_result* result, weft_metric** metric) {
  return guarded([&] {
    require_place(metric, "metric");
    give_metric(metric, metric_in(*result_of(result)));
  });
}

weft_status weft_result_fields(const weft_result* result, weft_fields** fields) {
  return guarded([&] {
    require_place(fields, "fields");
    give_fields(fields, fields_in(*result_of(result)));
  });
}

weft_status weft_result_part(const weft_result* result, weft_part** part) {
  return guarded([&] {
    require_place(part, "part");
    const auto known = result_of(result);
    require(known->part != nullptr, "result: is not one of a mesh in parts");
    auto object = std::make_shared<PartObject>();
    object->part = member(known->part, known->part->part);
    give(part, std::move(object));
  });
}

weft_status weft_result_write(const weft_result* result, const char* path) {
  return guarded([&] {
    const std::string file = require_text(path, "path");
    const auto known = result_of(result);
    const auto fields = fields_in(*known);
    weft::write_result(file, *mesh_in(*known), *metric_in(*known), *fields);
  });
}

weft_status weft_result_verdict(const weft_result* result, int* goal_met, int* cancelled) {
  return guarded([&] {
    const auto known = result_of(result);
    const std::lock_guard lock(known->mutex);
    const bool ended = was_cancelled(*known);  // and so has not met its goal
    if (goal_met) *goal_met = !ended && is_met(*known) ? 1 : 0;
    if (cancelled) *cancelled = ended ? 1 : 0;
  });
}

weft_status weft_result_summary(const weft_result* result, const char** text) {
  return guarded([&] {
    require_place(text, "text");
    const auto known = result_of(result);
    const std::lock_guard lock(known->mutex);
    if (known->summary.empty())
      known->summary = known->files ? weft::summary(*known->files) : weft::summary(measured(*known));
    *text = known->summary.c_str();
  });
}

weft_status weft_result_json(const weft_result* result, const char** text) {
  return guarded([&] {
    require_place(text, "text");
    const auto known = result_of(result);
    const std::lock_guard lock(known->mutex);
    if (known->json.empty()) known->json = weft::to_json(measured(*known));
    *text = known->json.c_str();
  });
}

weft_status weft_result_told(const weft_result* result, weft_told what, weft_text** text) {
  return guarded([&] {
    require_place(text, "text");
    const auto known = result_of(result);
    const std::lock_guard lock(known->mutex);
    if (known->filled) return give_told(*known->filled, what, text);
    give_told(what == WEFT_MISSED ? measured(*known) : known->report(), what, text);
  });
}

weft_status weft_result_fill(const weft_result* result, weft_fill_account* account) {
  return guarded([&] {
    require_place(account, "account");
    const auto known = result_of(result);
    require(known->filled != nullptr, "result: is not one of weft_fill_to_result()");
    const weft::FillResult& filled = *known->filled;
    fill_sized(*account,
               {sizeof(weft_fill_account), static_cast<int64_t>(filled.regions), filled.deviation,
                filled.grid_seconds, filled.fill_seconds},
               "account");
  });
}

weft_status weft_result_report(const weft_result* result, const char** report, const char** error) {
  return guarded([&] {
    const auto known = result_of(result);
    require(known->files != nullptr, "result: is not one of files");
    if (report) *report = known->files->report.c_str();
    if (error) *error = known->files->report_error.c_str();
  });
}

weft_status weft_result_measures(const weft_result* result, weft_measures* measures) {
  return guarded([&] {
    require_place(measures, "measures");
    const auto known = result_of(result);
    const std::lock_guard lock(known->mutex);
    fill_sized(*measures, measures_of(final_measures(*known)), "measures");
  });
}

weft_status weft_measure(const weft_mesh* mesh, const weft_metric* metric, weft_measures* measures) {
  return guarded([&] {
    require_place(measures, "measures");
    const auto known = object_of<MeshObject>(mesh, "mesh")->mesh;
    const auto given = object_of<MetricObject>(metric, "metric")->metric;
    fill_sized(*measures, measures_of(weft::measure(*known, *given)), "measures");
  });
}

weft_status weft_part_mesh(const weft_part* part, weft_mesh** mesh) {
  return guarded([&] {
    require_place(mesh, "mesh");
    const auto known = part_of(part);
    give_mesh(mesh, member(known, known->mesh));
  });
}

weft_status weft_part_fields(const weft_part* part, weft_fields** fields) {
  return guarded([&] {
    require_place(fields, "fields");
    const auto known = part_of(part);
    give_fields(fields, member(known, known->fields));
  });
}

weft_status weft_part_points(const weft_part* part, const uint64_t** ids, const int** owners) {
  return guarded([&] {
    const auto known = part_of(part);
    if (ids) *ids = known->ids.empty() ? nullptr : known->ids.data();
    if (owners) *owners = known->owners.empty() ? nullptr : known->owners.data();
  });
}

weft_status weft_part_ghosts(const weft_part* part, int64_t* num_own_tets, const int** owners) {
  return guarded([&] {
    const auto known = part_of(part);
    if (num_own_tets)
      *num_own_tets =
          static_cast<int64_t>(known->owners.empty() ? known->mesh.tets.size() : known->num_own_tets);
    if (owners) *owners = known->ghost_owners.empty() ? nullptr : known->ghost_owners.data();
  });
}

}  // extern "C"
