// Builds the JSON values.
#include "tools/library/report/report_json.h"

#include "engine/json/json.h"
#include "tools/library/jobs/distributed_stats.h"
#include "tools/library/report/model_text.h"
#include "tools/library/version.h"

namespace weft::tools {
namespace {

using Json = nlohmann::ordered_json;
using meshing::Verdict;

Json json_of(const meshing::Histogram& histogram) {
  return {{"lo", histogram.lo},         {"hi", histogram.hi},       {"logarithmic", histogram.logarithmic},
          {"counts", histogram.counts}, {"below", histogram.below}, {"above", histogram.above}};
}

Json json_of(const MeshCounts& counts) {
  return {{"vertices", counts.vertices},
          {"tets", counts.tets},
          {"triangles", counts.triangles},
          {"edges", counts.edges}};
}

Json json_of(const meshing::OperationCounts& counts) {
  Json all = Json::object();
  for (std::size_t o = 0; o < meshing::kOperatorNames.size(); ++o) {
    const auto op = static_cast<meshing::Operator>(o);
    const OperatorTally t = tally(counts, op);
    Json refused = Json::object();
    for (std::size_t v = 0; v < meshing::kVerdictNames.size(); ++v) {
      const auto verdict = static_cast<Verdict>(v);
      if (verdict == Verdict::accepted || verdict == Verdict::not_needed || verdict == Verdict::conflict)
        continue;
      refused[std::string(meshing::kVerdictNames[v])] = counts(op, verdict);
    }
    all[std::string(meshing::kOperatorNames[o])] = {{"tried", t.tried},
                                                    {"done", t.done},
                                                    {"refused", refused},
                                                    {"rolled_back", t.rolled_back},
                                                    {"not_needed", t.not_needed}};
  }
  return all;
}

Json json_of(const meshing::StageReport& stage) {
  return {{"name", stage.name},
          {"seconds", stage.seconds},
          {"vertices", stage.vertices},
          {"tets", stage.tets},
          {"operations", json_of(stage.counts)}};
}

Json json_of(const StageTimes& times) {
  return {{"read", times.read},   {"metric", times.metric},   {"decompose", times.decompose},
          {"adapt", times.adapt}, {"measure", times.measure}, {"fields", times.fields},
          {"write", times.write}, {"total", times.total}};
}

const char* name_of(meshing::TransferMethod method) {
  return method == meshing::TransferMethod::linear ? "linear" : "conservative";
}

Json json_of(const meshing::ComponentAccount& a) {
  return {{"name", a.name},
          {"integral_before", a.integral_before},
          {"integral_after", a.integral_after},
          {"integral_of_absolute", a.absolute},
          {"back_difference_l2", a.difference_l2},
          {"norm_l2", a.norm_l2},
          {"back_difference_max", a.difference_max},
          {"norm_max", a.norm_max},
          {"beyond_bounds", a.beyond_bounds},
          {"stays_definite", a.stays_definite}};
}

Json fields_json(const RunResult& run) {
  Json components = Json::array();
  for (const meshing::ComponentAccount& account : run.field_accounts) components.push_back(json_of(account));
  return {{"transfer", name_of(run.transfer)}, {"components", components}};
}

Json json_of(const std::vector<OperationTime>& operations) {
  Json seconds = Json::object();
  for (const OperationTime& t : operations) seconds[t.name] = t.seconds;
  return seconds;
}

Json json_of(const CheckpointStats& c) {
  return {{"written", c.written},
          {"bytes", c.bytes},
          {"seconds", c.seconds},
          {"resumed", c.resumed},
          {"failure", c.failure}};
}

Json json_of(const ExchangeStats& e) {
  return {{"messages", e.messages},
          {"peers", e.peers},
          {"most_messages", e.most_messages},
          {"most_peers", e.most_peers}};
}

Json json_of(const DistributedStats& a) {
  Json shifts = Json::array(), ranks = Json::array();
  for (const ShiftStats& s : a.shifts)
    shifts.push_back({{"shift", s.round + 1},
                      {"vertices_wanted", s.wanted},
                      {"tets_moved", s.moved},
                      {"receivers", s.receivers},
                      {"vertices_freed", s.thawed}});
  for (const RankStats& r : a.by_rank)
    ranks.push_back({{"rank", r.rank}, {"seconds_by_operation", json_of(r.operations)}});
  return {{"subdomains", a.subdomains},
          {"partitioner", a.partitioner},
          {"ranks", a.ranks},
          {"layers", a.layers},
          {"checks", a.checks},
          {"decomposition_seconds", a.decomposition_seconds},
          {"adaptation_seconds", a.adaptation_seconds},
          {"seconds_by_operation", json_of(a.sum)},
          {"share_beside_adaptation", a.beside_adaptation},
          {"coarse_shifts", a.coarse_shifts},
          {"divided_from", a.divided_from},
          {"shifts", shifts},
          {"by_rank", ranks},
          {"exchanged_by_rank",
           {{"before_loop", json_of(a.exchanged_before)},
            {"in_loop", json_of(a.exchanged_in_loop)},
            {"after_loop", json_of(a.exchanged_after)}}},
          {"former_interface", tools::json_of(a.former_interface)},
          {"checkpoints", json_of(a.checkpoints)},
          {"engine", engine::json_of(*a.engine)}};
}

Json json_of(const MetricFit& fit) {
  return {{"share_long", fit.edges_long},
          {"share_short", fit.edges_short},
          {"quality_mean", fit.quality_mean},
          {"tets_of_complexity", fit.tets_of_complexity}};
}

Json json_of(const std::vector<Mend>& mends) {
  Json all = Json::array();
  for (const Mend& m : mends)
    all.push_back({{"what", m.what},
                   {"entity", m.entity},
                   {"count", m.count},
                   {"examples", m.examples},
                   {"amount", m.amount},
                   {"unit", m.unit}});
  return all;
}

Json json_of(const SurfaceLimit& limit) {
  if (limit.vertices == 0) return nullptr;
  return {{"vertices", limit.vertices},
          {"longest", limit.longest},
          {"where", {limit.where.x, limit.where.y, limit.where.z}}};
}

Json json_of(const std::vector<SurfaceDemand>& demands) {
  Json all = Json::array();
  for (const SurfaceDemand& d : demands)
    all.push_back({{"reference", d.ref},
                   {"edges", d.edges},
                   {"allowed", d.allowed},
                   {"where", {d.where.x, d.where.y, d.where.z}}});
  return all;
}

}  // namespace

Json json_of(const meshing::Measures& m) {
  return {{"vertices", m.num_vertices},
          {"tets", m.num_tets},
          {"edges", m.num_edges},
          {"triangles", m.num_triangles},
          {"volume", m.volume},
          {"complexity", m.complexity},
          {"quality",
           {{"mean", m.quality_mean},
            {"min", m.quality_min},
            {"quantile_0.01", m.quality_q01},
            {"quantile_0.001", m.quality_q001},
            {"share_below_0.1", m.quality_below_01},
            {"share_below_0.2", m.quality_below_02},
            {"share_above_0.8", m.quality_above_08},
            {"histogram", json_of(m.quality)},
            {"histogram_log", json_of(m.quality_log)}}},
          {"edge_length",
           {{"mean", m.length_mean},
            {"min", m.length_min},
            {"max", m.length_max},
            {"share_unit", m.edges_unit},
            {"share_short", m.edges_short},
            {"share_long", m.edges_long},
            {"histogram", json_of(m.length)},
            {"histogram_log", json_of(m.length_log)}}}};
}

Json json_of(const RunResult& run) {
  Json stages = Json::array();
  for (const meshing::StageReport& stage : run.stages) stages.push_back(json_of(stage));
  return {
      {"schema", "weft-report-1"},
      {"version", kVersion},
      {"arguments", run.arguments},
      {"input", json_of(run.input_counts)},
      {"output", json_of(run.output_counts)},
      {"target_complexity", run.target_complexity},
      {"asked_complexity", run.complexity_asked ? Json(run.target_complexity) : Json()},
      {"predicted",
       {{"vertices", run.predicted.vertices}, {"tets", run.predicted.tets}, {"bytes", run.predicted.bytes}}},
      {"goal_met", run.goal_met()},
      {"goals_missed", run.missed},
      {"left_as_is", run.left_as_is ? json_of(*run.left_as_is) : Json(nullptr)},
      {"interrupted", run.cancelled},
      {"ended_by", run.ended_by},
      {"mends", json_of(run.mends)},
      {"before", run.before ? json_of(*run.before) : Json(nullptr)},
      {"after", run.after ? json_of(*run.after) : Json(nullptr)},
      {"stages", stages},
      {"operations", json_of(run.operations)},
      {"subdomains", run.distributed ? json_of(*run.distributed) : Json(nullptr)},
      {"checkpoints", run.checkpoints ? json_of(*run.checkpoints) : Json(nullptr)},
      {"fields", run.field_accounts.empty() ? Json(nullptr) : fields_json(run)},
      {"surface_deviation", run.surface_deviation},
      {"hausd", run.hausd},
      {"surface_limit", json_of(run.surface_limit)},
      {"surface_demands", json_of(run.surface_demands)},
      {"model", run.model ? json_of(*run.model) : Json(nullptr)},
      {"seconds", json_of(run.times)},
      {"measure_input_seconds", run.times.measure_input},
      {"peak_memory_bytes", run.peak_memory},
      {"threads", run.threads},
      {"warnings", run.warnings}};
}

std::string text_of(const nlohmann::ordered_json& document, int indent) {
  return document.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace weft::tools
