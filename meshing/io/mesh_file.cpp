// The table of formats: which extension is read and written by what, and what each can hold.
#include "meshing/io/mesh_file.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/cgns_part.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/io/gmf/gmf_slice.h"
#include "meshing/io/gmsh/gmsh.h"
#include "meshing/io/gmsh/gmsh_writer.h"
#include "meshing/io/obj.h"
#include "meshing/io/off.h"
#include "meshing/io/ply.h"
#include "meshing/io/stl.h"
#include "meshing/io/su2.h"
#include "meshing/io/ugrid.h"
#include "meshing/io/vtk/pvtu.h"
#include "meshing/io/vtk/vtu.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

/// What a format can keep.
enum Keeps : unsigned {
  kTets = 1u << 0,
  kEdges = 1u << 1,
  kCorners = 1u << 2,
  kMarks = 1u << 3,  ///< ridges and whatever is required
  kPointRefs = 1u << 4,
  kTetRefs = 1u << 5,
  kTriangleRefs = 1u << 6,
  kNames = 1u << 7,
  kScalars = 1u << 8,
  kVectors = 1u << 9,  ///< and tensors
  kFields = kScalars | kVectors,
  kAssociation = 1u << 10,  ///< with a CAD model
};

struct Format {
  std::string_view extension;
  unsigned keeps;
  MeshContents (*read)(const fs::path&, Coordinates);
  void (*write)(const fs::path&, const MeshView&, const WriteOptions&);
  void (*load)(const fs::path&) = nullptr;  ///< what a part of weft does; throws where it is missing
  std::optional<MeshSize> (*size)(const fs::path&) = nullptr;  ///< where ranges can be read
  MeshContents (*read_range)(const fs::path&, const MeshRange&) = nullptr;
  // Where the mesh may be in pieces: the files that have them, how large these pieces are, and parts of them.
  std::vector<fs::path> (*sources)(const fs::path&) = nullptr;
  std::vector<PieceSize> (*piece_sizes)(const fs::path&) = nullptr;
  PieceRanges (*read_piece_ranges)(const fs::path&, std::span<const PieceRange>) = nullptr;
  std::vector<MeshContents> (*read_piece_fields)(const fs::path&, std::span<const PieceRange>) = nullptr;
  /// Where fields are not told of by read_piece_fields.
  SolutionData (*field_heads)(const fs::path&) = nullptr;
  // Where one reader can pass on what it reads: whether of this file, and how.
  bool (*is_streamed)(const fs::path&) = nullptr;
  MeshContents (*stream)(const fs::path&, MeshStream&) = nullptr;
  void (*stream_fields)(const fs::path&, FieldStream&) = nullptr;
  // Where many can write one file: whether they can write this one, what one of them does first, and all do.
  bool (*in_parts)(const fs::path&, const WriteOptions&) = nullptr;
  PartPlaces (*begin_parts)(const fs::path&, const fs::path&, const WholeMesh&) = nullptr;
  std::unique_ptr<PartWriter> (*open_part)(PartTarget, const WholeMesh&, const PartPlaces&) = nullptr;
  bool (*has_short_reals)(const fs::path&) = nullptr;
  // Where many can write one file of text: whether this one, what stands before the rows of its sections, and
  // the rows.
  bool (*as_text)(const fs::path&, const WriteOptions&) = nullptr;
  std::vector<std::string> (*text_heads)(const fs::path&, const WholeMesh&) = nullptr;
  std::unique_ptr<TextPart> (*open_text_part)(const WholeMesh&, const MeshPart&) = nullptr;
};

/// Surfaces have finite coordinates.
template <MeshContents (*read)(const fs::path&)>
MeshContents read_surface(const fs::path& path, Coordinates) {
  return read(path);
}
std::optional<MeshSize> gmf_size(const fs::path& path) {
  const GmfLayout layout = read_gmf_layout(path);
  return MeshSize{layout.num_points(), layout.num_tets()};
}
MeshContents read_gmf_range(const fs::path& path, const MeshRange& range) {
  const GmfLayout layout = read_gmf_layout(path);
  MeshContents contents;
  contents.mesh = read_gmf_boundary(path, layout, range);
  GmfPoints points = read_gmf_points(path, layout, range.first_point, range.num_points);
  contents.mesh.points = std::move(points.points);
  contents.mesh.point_refs = std::move(points.refs);
  GmfTets tets = read_gmf_tets(path, layout, range.first_tet, range.num_tets);
  contents.mesh.tets = std::move(tets.tets);
  contents.mesh.tet_refs = std::move(tets.refs);
  contents.fields.num_points = range.num_points;
  contents.dropped = layout.dropped();
  return contents;
}
bool gmsh_has_no_ranges(const fs::path& path) { return !gmsh_size(path); }
/// What the part of weft that knows CGNS does with a file.
template <auto function, class... Arguments>
auto by_cgns(const fs::path& path, Arguments... arguments) {
  return (cgns_part(path).*function)(path, std::forward<Arguments>(arguments)...);
}
std::unique_ptr<PartWriter> open_cgns(PartTarget target, const WholeMesh& whole, const PartPlaces& places) {
  const CgnsPart& part = cgns_part(target.name);
  return part.open_part(std::move(target), whole, places);
}
void write_gmf(const fs::path& path, const MeshView& contents, const WriteOptions&) {
  write_gmf_mesh(path, contents.mesh);
}
constexpr unsigned kGmf =
    kTets | kEdges | kCorners | kMarks | kPointRefs | kTetRefs | kTriangleRefs | kAssociation;
constexpr unsigned kVtu = kTets | kEdges | kCorners | kPointRefs | kTetRefs | kTriangleRefs | kFields;
bool always(const fs::path&) { return true; }
bool whatever_options(const fs::path&, const WriteOptions&) { return true; }
/// Of the file's name alone.
template <bool (*of_name)(const fs::path&)>
bool by_name(const fs::path& path, const WriteOptions&) {
  return of_name(path);
}
bool is_ascii(const fs::path&, const WriteOptions& options) {
  return options.encoding == WriteOptions::Encoding::ascii;
}
bool is_binary(const fs::path& path, const WriteOptions& options) { return !is_ascii(path, options); }
bool is_raw(const fs::path& path, const WriteOptions& options) {
  return is_binary(path, options) && !options.compress;
}
/// Of the mesh alone.
template <std::vector<std::string> (*of_mesh)(const WholeMesh&)>
std::vector<std::string> heads(const fs::path&, const WholeMesh& whole) {
  return of_mesh(whole);
}
/// Binary and text alike: what a file is, it says itself.
constexpr Format gmf_format(std::string_view extension) {
  return {.extension = extension,
          .keeps = kGmf,
          .read = read_gmf,
          .write = write_gmf,
          .size = gmf_size,
          .read_range = read_gmf_range,
          .is_streamed = gmf::is_text,
          .stream = stream_gmf};
}
constexpr std::array kFormats = {
    gmf_format(".meshb"),
    gmf_format(".mesh"),
    Format{.extension = ".msh",
           .keeps = kTets | kEdges | kCorners | kTetRefs | kTriangleRefs | kNames | kFields,
           .read = read_gmsh,
           .write = write_gmsh,
           .size = gmsh_size,
           .read_range = read_gmsh_range,
           .field_heads = gmsh_field_heads,
           .is_streamed = gmsh_has_no_ranges,
           .stream = stream_gmsh,
           .stream_fields = stream_gmsh_fields,
           .in_parts = is_binary,
           .begin_parts = begin_gmsh_parts,
           .open_part = open_gmsh_part,
           .as_text = is_ascii,
           .text_heads = gmsh_heads,
           .open_text_part = open_gmsh_text_part},
    Format{.extension = ".ugrid",
           .keeps = kTets | kTetRefs | kTriangleRefs,
           .read = read_ugrid,
           .write = write_ugrid,
           .size = ugrid_size,
           .read_range = read_ugrid_range,
           .is_streamed = is_ascii_ugrid,
           .stream = stream_ugrid,
           .in_parts = by_name<is_binary_ugrid>,
           .begin_parts = begin_ugrid_parts,
           .open_part = open_ugrid_part,
           .has_short_reals = has_ugrid_short_reals,
           .as_text = by_name<is_ascii_ugrid>,
           .text_heads = heads<ugrid_heads>,
           .open_text_part = open_ugrid_text_part},
    Format{.extension = ".su2",
           .keeps = kTets | kTriangleRefs | kNames,
           .read = read_su2,
           .write = write_su2,
           .is_streamed = always,
           .stream = stream_su2,
           .as_text = whatever_options,
           .text_heads = heads<su2_heads>,
           .open_text_part = open_su2_part},
    Format{.extension = ".vtu",
           .keeps = kVtu,
           .read = read_vtu,
           .write = write_vtu,
           .size = vtu_size,
           .read_range = read_vtu_range,
           .piece_sizes = vtu_piece_sizes,
           .read_piece_ranges = read_vtu_piece_ranges,
           .read_piece_fields = read_vtu_piece_fields,
           .in_parts = is_raw,
           .begin_parts = begin_vtu_parts,
           .open_part = open_vtu_part,
           .as_text = is_ascii,
           .text_heads = heads<vtu_heads>,
           .open_text_part = open_vtu_text_part},
    Format{
        .extension = ".pvtu", .keeps = kVtu, .read = read_pvtu, .write = write_pvtu, .sources = pvtu_sources},
    Format{.extension = ".cgns",
           .keeps = kTets | kEdges | kTetRefs | kTriangleRefs | kNames | kFields,
           .read = by_cgns<&CgnsPart::read>,
           .write = by_cgns<&CgnsPart::write>,
           .load = [](const fs::path& path) { cgns_part(path); },
           .size = by_cgns<&CgnsPart::size>,
           .read_range = by_cgns<&CgnsPart::read_range>,
           .piece_sizes = by_cgns<&CgnsPart::piece_sizes>,
           .read_piece_ranges = by_cgns<&CgnsPart::read_piece_ranges>,
           .read_piece_fields = by_cgns<&CgnsPart::read_piece_fields>,
           .in_parts = whatever_options,
           .begin_parts = by_cgns<&CgnsPart::begin_parts>,
           .open_part = open_cgns},
    Format{".stl", kTriangleRefs, read_surface<read_stl>, write_stl},
    Format{".obj", kEdges | kTriangleRefs | kNames, read_surface<read_obj>, write_obj},
    Format{".off", 0, read_surface<read_off>, write_off},
    Format{".ply", kEdges | kTriangleRefs | kPointRefs | kScalars, read_surface<read_ply>, write_ply},
};

const Format* find_format(const fs::path& path) {
  const auto found = std::ranges::find(kFormats, path.extension().string(), &Format::extension);
  return found == kFormats.end() ? nullptr : &*found;
}

[[noreturn]] void fail_extension(const fs::path& path, const std::string& known) {
  const std::string extension = path.extension().string();
  throw InputError(
      path.string(), "",
      (extension.empty() ? "no extension" : "unexpected extension " + extension) + ", it must be " + known);
}

/// The extensions of the formats that keep all of `wanted`.
std::string list_extensions(unsigned wanted) {
  std::vector<std::string_view> names;
  for (const Format& format : kFormats) {
    if ((format.keeps & wanted) == wanted) names.push_back(format.extension);
  }
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

const Format& format_of(const fs::path& path) {
  const Format* format = find_format(path);
  if (!format) fail_extension(path, mesh_extensions());
  return *format;
}

bool is_gmf_solution(const fs::path& path) {
  return path.extension() == ".solb" || path.extension() == ".sol";
}

/// What has pieces and is none of these formats is one of the files that a .pvtu names, however it is called.
const Format& format_of_source(const fs::path& source) {
  const Format* format = find_format(source);
  return format && format->piece_sizes ? *format : *std::ranges::find(kFormats, ".vtu", &Format::extension);
}

/// Fields that the file itself does not hold; where it holds no volumes none can go beside it either.
std::uint64_t count_lost_fields(unsigned keeps, const SolutionData& fields) {
  if (!(keeps & kFields) && (keeps & kTets)) return 0;
  return static_cast<std::uint64_t>(std::ranges::count_if(fields.fields, [keeps](const Field& field) {
    return !(keeps & (field.kind == Field::Kind::scalar ? kScalars : kVectors));
  }));
}

}  // namespace

void refuse_foreign_volumes(std::uint64_t count, const fs::path& path) {
  if (count == 0) return;
  throw InputError(path.string(), "",
                   "has " + std::to_string(count) +
                       " volume elements other than linear tetrahedra, which weft does not adapt");
}

MeshContents read_mesh_contents(const fs::path& path, Coordinates wanted) {
  return format_of(path).read(path, wanted);
}

std::optional<MeshSize> size_for_ranges(const fs::path& path) {
  const Format& format = format_of(path);
  return format.size ? format.size(path) : std::nullopt;
}

MeshContents read_mesh_range(const fs::path& path, const MeshRange& range, OtherVolumes others) {
  MeshContents contents = format_of(path).read_range(path, range);
  if (others == OtherVolumes::refused) refuse_foreign_volumes(contents.foreign_volumes, path);
  return contents;
}

bool can_be_in_pieces(const fs::path& path) {
  const Format& format = format_of(path);
  return format.sources || format.piece_sizes;
}

std::vector<fs::path> piece_sources(const fs::path& path) {
  const Format& format = format_of(path);
  return format.sources ? format.sources(path) : std::vector<fs::path>{path};
}

std::vector<PieceSize> piece_sizes(const fs::path& source) {
  return format_of_source(source).piece_sizes(source);
}

PieceRanges read_piece_ranges(const fs::path& source, std::span<const PieceRange> ranges) {
  return format_of_source(source).read_piece_ranges(source, ranges);
}

std::vector<MeshContents> read_piece_fields(const fs::path& source, std::span<const PieceRange> ranges) {
  return format_of_source(source).read_piece_fields(source, ranges);
}

SolutionData field_heads(const fs::path& path) {
  const Format& format = format_of(path);
  if (format.field_heads) return format.field_heads(path);
  if (!can_be_in_pieces(path)) return {};
  const std::vector<fs::path> sources = piece_sources(path);
  if (sources.empty()) return {};
  const PieceRange none{.rows = {}, .others = false};
  std::vector<MeshContents> first = read_piece_fields(sources.front(), {&none, 1});
  return first.empty() ? SolutionData{} : std::move(first.front().fields);
}

bool can_be_streamed(const fs::path& path) {
  const Format& format = format_of(path);
  return format.is_streamed && format.is_streamed(path);
}

MeshContents stream_mesh(const fs::path& path, MeshStream& stream, OtherVolumes others) {
  MeshContents contents = format_of(path).stream(path, stream);
  if (others == OtherVolumes::refused) refuse_foreign_volumes(contents.foreign_volumes, path);
  return contents;
}

bool can_stream_fields(const fs::path& path) { return format_of(path).stream_fields != nullptr; }
void stream_fields(const fs::path& path, FieldStream& fields) { format_of(path).stream_fields(path, fields); }

MeshData read_mesh(const fs::path& path, RefNames* names, Coordinates wanted) {
  MeshContents contents = read_mesh_contents(path, wanted);
  refuse_foreign_volumes(contents.foreign_volumes, path);
  if (names) *names = std::move(contents.names);
  return std::move(contents.mesh);
}

Association read_carried_model(const fs::path& path) {
  return format_of(path).read == &read_gmf ? read_gmf_model(path, read_gmf_layout(path)) : Association{};
}

bool has_association(const fs::path& path) {
  if (format_of(path).read != &read_gmf) return false;
  const GmfLayout layout = read_gmf_layout(path);
  return std::ranges::any_of(
      std::array{gmf::kVerticesOnNodes, gmf::kVerticesOnEdges, gmf::kVerticesOnFaces, gmf::kByteFlow},
      [&](gmf::Keyword keyword) { return layout.find(keyword) != nullptr; });
}

SolutionData read_solution(const fs::path& path) {
  if (is_gmf_solution(path)) return read_gmf_solution(path);
  if (!holds_fields(path)) fail_extension(path, ".solb, .sol or that of a mesh file that holds fields");
  SolutionData fields = read_mesh_contents(path).fields;
  if (fields.fields.empty()) throw InputError(path.string(), "", "holds no fields at vertices");
  return fields;
}

void write_mesh(const fs::path& path, const MeshData& mesh, const SolutionData* fields) {
  static const SolutionData kNoFields;
  static const RefNames kNoNames;
  write_mesh_contents(path, MeshView(mesh, fields ? *fields : kNoFields, kNoNames));
  if (fields && !holds_fields(path)) write_gmf_solution(solution_beside(path), *fields);
}

void write_mesh_contents(const fs::path& path, const MeshView& contents, const WriteOptions& options) {
  format_of(path).write(path, contents, options);
}

bool can_be_written_in_parts(const fs::path& path, const WriteOptions& options) {
  const Format& format = format_of(path);
  return format.in_parts && format.in_parts(path, options);
}

PartPlaces begin_parts(const fs::path& file, const fs::path& name, const WholeMesh& whole) {
  return format_of(name).begin_parts(file, name, whole);
}

std::unique_ptr<PartWriter> open_part(PartTarget target, const WholeMesh& whole, const PartPlaces& places) {
  const Format& format = format_of(target.name);
  return format.open_part(std::move(target), whole, places);
}

bool has_short_reals(const fs::path& path) {
  const Format& format = format_of(path);
  return format.has_short_reals && format.has_short_reals(path);
}

bool can_be_written_in_blocks(const fs::path& path, const WriteOptions& options) {
  return format_of(path).extension == ".vtu" && is_binary(path, options) && options.compress;
}

bool can_be_written_as_text(const fs::path& path, const WriteOptions& options) {
  const Format& format = format_of(path);
  return format.as_text && format.as_text(path, options);
}

std::vector<std::string> text_heads(const fs::path& name, const WholeMesh& whole) {
  return format_of(name).text_heads(name, whole);
}

std::unique_ptr<TextPart> open_text_part(const fs::path& name, const WholeMesh& whole, const MeshPart& part) {
  return format_of(name).open_text_part(whole, part);
}

std::uint64_t count_nonzero(const std::vector<std::int32_t>& refs) {
  return static_cast<std::uint64_t>(std::ranges::count_if(refs, [](std::int32_t ref) { return ref != 0; }));
}

ContentCounts counts_of(const MeshData& mesh) {
  const Association& on_model = mesh.association;
  return {.tets = mesh.tets.size(),
          .edges = mesh.edges.size(),
          .corners = mesh.corners.size(),
          .ridges = mesh.ridges.size(),
          .required_points = mesh.required_points.size(),
          .required_edges = mesh.required_edges.size(),
          .required_triangles = mesh.required_triangles.size(),
          .point_refs = count_nonzero(mesh.point_refs),
          .tet_refs = count_nonzero(mesh.tet_refs),
          .on_model = on_model.nodes.size() + on_model.edges.size() + on_model.faces.size(),
          .models = on_model.model.empty() ? 0u : 1u};
}

std::vector<Dropped> lost_in(const fs::path& path, const ContentCounts& mesh, const SolutionData& fields,
                             const RefNames& names, const WriteOptions& options) {
  const unsigned keeps = format_of(path).keeps;
  MeshContents lost;
  if (!(keeps & kTets)) {
    lost.drop("tets", mesh.tets);
  } else if (!(keeps & kTetRefs)) {
    lost.drop("references of tets", mesh.tet_refs);
  }
  if (!(keeps & kEdges)) lost.drop("edges", mesh.edges);
  if (!(keeps & kCorners)) lost.drop("corners", mesh.corners);
  if (!(keeps & kMarks)) {
    lost.drop("ridges (among the edges)", mesh.ridges);
    lost.drop("marks of required vertices", mesh.required_points);
    lost.drop("marks of required edges", mesh.required_edges);
    lost.drop("marks of required triangles", mesh.required_triangles);
  }
  if (!(keeps & kAssociation)) {
    lost.drop("records of vertices on a CAD model", mesh.on_model);
    lost.drop("carried CAD models", mesh.models);
  }
  if (!(keeps & kPointRefs)) lost.drop("vertex references", mesh.point_refs);
  if (!(keeps & kNames)) lost.drop("names of references", names.all().size());
  lost.drop("fields", count_lost_fields(keeps, fields));
  if (path.extension() == ".stl" && options.encoding != WriteOptions::Encoding::ascii) {
    lost.dropped.push_back({"digits of coordinates beyond 32 bits (ASCII keeps them)", 0});
  }
  return lost.dropped;
}

void write_solution(const fs::path& path, const SolutionData& solution) {
  if (!is_gmf_solution(path)) fail_extension(path, ".solb or .sol");
  write_gmf_solution(path, solution);
}

fs::path solution_beside(const fs::path& mesh) {
  fs::path solution = mesh;
  solution.replace_extension(mesh.extension() == ".mesh" ? ".sol" : ".solb");
  return solution;
}

void require_part(const fs::path& path) {
  const Format* format = find_format(path);
  if (format && format->load) format->load(path);
}

bool is_mesh_name(const fs::path& path) { return find_format(path) != nullptr; }
bool holds_volumes(const fs::path& path) { return (format_of(path).keeps & kTets) != 0; }
bool holds_fields(const fs::path& path) {
  const Format* format = find_format(path);
  return format && (format->keeps & kFields);
}

std::string mesh_extensions() { return list_extensions(0); }
std::string volume_extensions() { return list_extensions(kTets); }

}  // namespace weft::meshing
