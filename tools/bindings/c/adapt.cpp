// Adaptation: of one mesh, of files, of a mesh in parts; initial meshes.
#include <cstring>
#include <utility>
#include <vector>

#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"

namespace weft::c {
namespace {

/// The options of a call while it lasts; a cancel that the caller's function has asked for ends with it.
class Asked {
 public:
  explicit Asked(const weft_options* handle) : object_(object_or_none<OptionsObject>(handle, "options")) {}
  ~Asked() {
    if (object_ && object_->callback_cancelled.exchange(false)) object_->cancel = false;
  }
  Asked(const Asked&) = delete;
  Asked& operator=(const Asked&) = delete;
  const Options& operator*() const { return object_ ? object_->options : defaults_; }
  const Options* operator->() const { return &**this; }

 private:
  std::shared_ptr<OptionsObject> object_;
  Options defaults_;
};

/// What one rank brings along.
struct PartCall {
  std::shared_ptr<Part> part;
  std::shared_ptr<const Metric> metric;
};

PartCall check_part_call(const weft_part* part, const weft_metric* metric, const Options& options,
                         weft_result** result) {
  require_place(result, "result");
  PartCall call;
  call.part = object_of<PartObject>(part, "part")->part;
  if (metric || !options.metric.given()) call.metric = object_of<MetricObject>(metric, "metric")->metric;
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

/// All ranks: what one of them cannot do, none does.
weft_status adapt_parts(MPI_Comm communicator, const weft_part* part, const weft_metric* metric,
                        const weft_options* options, weft_result** result) {
  check_communicator(communicator);
  std::string issue;
  PartCall call;
  std::shared_ptr<OptionsObject> known;
  try {
    known = object_or_none<OptionsObject>(options, "options");
    call = check_part_call(part, metric, known ? known->options : Options{}, result);
  } catch (...) {
    issue = issue_of(std::current_exception());
  }
  const RankError first = first_error(communicator, issue);
  if (first.rank >= 0) {
    set_last_error("rank " + std::to_string(first.rank) + ": " + first.text.substr(1));
    return static_cast<weft_status>(first.text[0] - '0');
  }
  const Asked asked(options);
  auto object = std::make_shared<ResultObject>();
  object->part =
      std::make_shared<PartResult>(call.metric ? adapt(communicator, *call.part, *call.metric, *asked)
                                               : adapt(communicator, *call.part, *asked));
  give(result, std::move(object));
  return WEFT_OK;
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

FillOptions fill_options(const weft_fill_settings& s, const Options& options) {
  FillOptions fill;
  fill.growth = s.growth;
  fill.size = s.max_size;
  fill.merge = s.merge;
  fill.materials = s.materials != 0;
  fill.remesh_surface = s.remesh_surface != 0;
  fill.geometry = options.geometry;
  fill.run = options.run;
  return fill;
}

weft_fill_settings default_fill() {
  const FillOptions fill;
  weft_fill_settings s{};
  s.size = sizeof s;
  s.growth = fill.growth;
  s.max_size = fill.size;
  s.merge = fill.merge;
  s.materials = fill.materials;
  s.remesh_surface = fill.remesh_surface;
  return s;
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_adapt(const weft_mesh* mesh, const weft_metric* metric, const weft_options* options,
                       const weft_fields* fields, weft_result** result) {
  return guarded([&] {
    require_place(result, "result");
    const auto input = mesh_of(mesh, "mesh");
    const auto given = object_or_none<MetricObject>(metric, "metric");
    const auto carried = object_or_none<FieldsObject>(fields, "fields");
    const Asked asked(options);
    const auto along = carried ? carried->fields : std::make_shared<weft::Fields>();
    if (!given && !asked->metric.given())
      throw weft::OptionError("--metric", "no metric: it is NULL, and no option makes one");
    auto object = std::make_shared<ResultObject>();
    object->whole = std::make_shared<weft::Result>(given ? weft::adapt(*input, *given->metric, *asked, *along)
                                                         : weft::adapt(*input, *asked, *along));
    give(result, std::move(object));
  });
}

weft_status weft_adapt_files(const char* input, const char* output, const weft_options* options,
                             weft_result** result) {
  return guarded([&] {
    require_place(result, "result");
    weft::Files files;
    files.input = require_text(input, "input");
    files.output = require_text(output, "output");
    const Asked asked(options);
    auto object = std::make_shared<ResultObject>();
    object->files = std::make_shared<weft::FilesResult>(weft::adapt_files(files, *asked));
    give(result, std::move(object));
  });
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
  weft_status agreed = WEFT_OK;
  const weft_status status =
      guarded([&] { agreed = adapt_parts(communicator, part, metric, options, result); });
  return status != WEFT_OK ? status : agreed;
}

weft_status weft_adapt_parts_f(int communicator, const weft_part* part, const weft_metric* metric,
                               const weft_options* options, weft_result** result) {
  int running = 0;
  MPI_Initialized(&running);
  return weft_adapt_parts(running ? MPI_Comm_f2c(communicator) : MPI_COMM_NULL, part, metric, options,
                          result);
}

weft_status weft_fill_settings_default(weft_fill_settings* settings) {
  return guarded([&] {
    require_place(settings, "settings");
    fill_sized(*settings, default_fill(), "settings");
  });
}

weft_status weft_fill(const weft_mesh* surface, const weft_fill_settings* settings,
                      const weft_options* options, weft_mesh** mesh, weft_metric** metric) {
  return guarded([&] {
    require_place(mesh, "mesh");
    const auto input = mesh_of(surface, "surface");
    weft_fill_settings known = default_fill();
    if (settings) copy_sized(&known, sizeof known, settings, settings->size, "settings");
    const Asked asked(options);
    weft::FillResult filled = weft::fill(*input, fill_options(known, *asked));
    if (metric) give_metric(metric, std::make_shared<const weft::Metric>(std::move(filled.metric)));
    give_mesh(mesh, std::make_shared<weft::Mesh>(std::move(filled.mesh)));
  });
}

}  // extern "C"
