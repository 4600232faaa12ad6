// Adaptation: of one mesh, and of a mesh in parts.
#include <utility>
#include <vector>

#include "tools/bindings/c/asked.h"
#include "tools/bindings/c/calls.h"

namespace weft::c {
namespace {

/// What one rank brings along. `background`, the part that `metric` belongs to: null where it is `part`.
struct PartCall {
  std::shared_ptr<Part> part, background;
  std::shared_ptr<const Metric> metric;
};

/// The handles of a call in parts. `in_background`: it is one to a background, which then is needed.
struct PartHandles {
  const weft_part *part, *background;
  bool in_background;
  const weft_metric* metric;
  const weft_options* options;
};

PartCall check_part_call(const PartHandles& given, const Options& options, weft_result** result) {
  require_place(result, "result");
  PartCall call;
  call.part = object_of<PartObject>(given.part, "part")->part;
  if (given.in_background) call.background = object_of<PartObject>(given.background, "background")->part;
  if (given.metric || !options.metric.given())
    call.metric = object_of<MetricObject>(given.metric, "metric")->metric;
  validate(options);
  return call;
}

/// An error as it is sent to other ranks: the status as one character, then the text.
std::string issue_of(const std::exception_ptr& error) {
  std::string text;
  const weft_status status = status_of(error, text);
  return static_cast<char>('0' + status) + text;
}

void check_communicator(MPI_Comm communicator) {
  int running = 0;
  MPI_Initialized(&running);
  require(running, "communicator: MPI has not been initialised");
  MPI_Finalized(&running);
  require(!running, "communicator: MPI has been finalised");
  require(communicator != MPI_COMM_NULL, "communicator: is MPI_COMM_NULL");
}

PartResult adapt_agreed(MPI_Comm communicator, const PartCall& call, const Options& options) {
  if (call.background)
    return call.metric ? adapt(communicator, *call.part, *call.background, *call.metric, options)
                       : adapt(communicator, *call.part, *call.background, options);
  return call.metric ? adapt(communicator, *call.part, *call.metric, options)
                     : adapt(communicator, *call.part, options);
}

/// All ranks: what one of them cannot do, none does.
weft_status adapt_parts(MPI_Comm communicator, const PartHandles& given, weft_result** result) {
  check_communicator(communicator);
  std::string issue;
  PartCall call;
  try {
    const auto known = object_or_none<OptionsObject>(given.options, "options");
    call = check_part_call(given, known ? known->options : Options{}, result);
  } catch (...) {
    issue = issue_of(std::current_exception());
  }
  const RankError first = first_error(communicator, issue);
  if (first.rank >= 0) {
    set_last_error("rank " + std::to_string(first.rank) + ": " + first.text.substr(1));
    return static_cast<weft_status>(first.text[0] - '0');
  }
  const Asked asked(given.options);
  auto object = std::make_shared<ResultObject>();
  object->part = std::make_shared<PartResult>(adapt_agreed(communicator, call, *asked));
  give(result, std::move(object));
  return WEFT_OK;
}

weft_status guarded_parts(MPI_Comm communicator, const PartHandles& given, weft_result** result) {
  weft_status agreed = WEFT_OK;
  const weft_status status = guarded([&] { agreed = adapt_parts(communicator, given, result); });
  return status != WEFT_OK ? status : agreed;
}

MPI_Comm from_fortran(int communicator) {
  int running = 0;
  MPI_Initialized(&running);
  return running ? MPI_Comm_f2c(communicator) : MPI_COMM_NULL;
}

std::vector<std::uint64_t> ids_of(const std::int64_t* ids, std::size_t count, const char* array) {
  std::vector<std::uint64_t> all(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (ids[i] < 0)
      throw InputError(
          "", "",
          std::string(array) + "[" + std::to_string(i) + "]: " + std::to_string(ids[i]) + " is negative");
    all[i] = static_cast<std::uint64_t>(ids[i]);
  }
  return all;
}

/// The mesh of the handle becomes the part's; the handle looks at it there.
void move_mesh(MeshObject& from, const std::shared_ptr<Part>& to) {
  if (from.mesh.use_count() > 1) {
    to->mesh = *from.mesh;
    return;
  }
  to->mesh = std::move(*from.mesh);
  from.mesh = std::shared_ptr<Mesh>(to, &to->mesh);
}

/// `background`: the mesh that the metric belongs to; null: `mesh`.
Result adapt_whole(const Mesh& mesh, const Mesh* background, const Metric* metric, const Options& options,
                   const Fields& fields) {
  if (background)
    return metric ? adapt(mesh, *background, *metric, options, fields)
                  : adapt(mesh, *background, options, fields);
  return metric ? adapt(mesh, *metric, options, fields) : adapt(mesh, options, fields);
}

void adapt_one(const weft_mesh* mesh, const std::shared_ptr<Mesh>& background, const weft_metric* metric,
               const weft_options* options, const weft_fields* fields, weft_result** result) {
  require_place(result, "result");
  const auto input = mesh_of(mesh, "mesh");
  const auto given = object_or_none<MetricObject>(metric, "metric");
  const auto carried = object_or_none<FieldsObject>(fields, "fields");
  const Asked asked(options);
  if (!given && !asked->metric.given())
    throw OptionError("--metric", "no metric: it is NULL, and no option makes one");
  auto object = std::make_shared<ResultObject>();
  object->whole =
      std::make_shared<Result>(adapt_whole(*input, background.get(), given ? given->metric.get() : nullptr,
                                           *asked, carried ? *carried->fields : Fields{}));
  give(result, std::move(object));
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_adapt(const weft_mesh* mesh, const weft_metric* metric, const weft_options* options,
                       const weft_fields* fields, weft_result** result) {
  return guarded([&] { adapt_one(mesh, nullptr, metric, options, fields, result); });
}

weft_status weft_adapt_to_background(const weft_mesh* mesh, const weft_mesh* background,
                                     const weft_metric* metric, const weft_options* options,
                                     const weft_fields* fields, weft_result** result) {
  return guarded(
      [&] { adapt_one(mesh, mesh_of(background, "background"), metric, options, fields, result); });
}

weft_status weft_part_create(weft_mesh* mesh, const int64_t* point_ids, const int64_t* tet_ids,
                             const weft_fields* fields, weft_part** part) {
  return guarded([&] {
    require_place(part, "part");
    const auto object = object_of<MeshObject>(mesh, "mesh");
    const auto carried = object_or_none<FieldsObject>(fields, "fields");
    const std::size_t points = object->mesh->points.size(), tets = object->mesh->tets.size();
    require_array(point_ids, static_cast<int64_t>(points), 1, "point_ids");
    auto made = std::make_shared<PartObject>();
    made->part = std::make_shared<weft::Part>();
    made->part->ids = ids_of(point_ids, points, "point_ids");
    if (tet_ids) made->part->tet_ids = ids_of(tet_ids, tets, "tet_ids");
    if (carried) made->part->fields = *carried->fields;
    move_mesh(*object, made->part);
    give(part, std::move(made));
  });
}

weft_status weft_adapt_parts(MPI_Comm communicator, const weft_part* part, const weft_metric* metric,
                             const weft_options* options, weft_result** result) {
  return guarded_parts(communicator, {part, nullptr, false, metric, options}, result);
}

weft_status weft_adapt_parts_f(int communicator, const weft_part* part, const weft_metric* metric,
                               const weft_options* options, weft_result** result) {
  return weft_adapt_parts(from_fortran(communicator), part, metric, options, result);
}

weft_status weft_adapt_parts_to_background(MPI_Comm communicator, const weft_part* part,
                                           const weft_part* background, const weft_metric* metric,
                                           const weft_options* options, weft_result** result) {
  return guarded_parts(communicator, {part, background, true, metric, options}, result);
}

weft_status weft_adapt_parts_to_background_f(int communicator, const weft_part* part,
                                             const weft_part* background, const weft_metric* metric,
                                             const weft_options* options, weft_result** result) {
  return weft_adapt_parts_to_background(from_fortran(communicator), part, background, metric, options,
                                        result);
}

}  // extern "C"
