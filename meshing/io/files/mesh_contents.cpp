// Names and numbers of references; a surface without its volume; folding of tensors.
#include "meshing/io/files/mesh_contents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "meshing/io/files/text_numbers.h"

namespace weft::meshing {
namespace {

constexpr std::string_view kDefaultName = "ref_";
constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

bool numbered_name(std::string_view name, std::int32_t& ref) {
  if (name.starts_with(kDefaultName)) name.remove_prefix(kDefaultName.size());
  const auto number = parse_integer(name);
  if (!number || !std::in_range<std::int32_t>(*number)) return false;
  ref = static_cast<std::int32_t>(*number);
  return true;
}

/// What of a text takes `bytes` at most, without a part of a character of UTF-8 at its end.
std::string first_characters(std::string_view text, std::size_t bytes) {
  constexpr std::size_t kLongestCharacter = 4;
  if (text.size() <= bytes) return std::string(text);
  std::size_t end = bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return std::string(text.substr(0, bytes - end < kLongestCharacter ? end : bytes));
}

/// New numbers of the points that triangles and edges use, in their old order.
std::vector<std::uint32_t> surface_numbers(const MeshData& mesh) {
  std::vector<std::uint32_t> numbers(mesh.points.size(), kUnused);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) numbers[v] = 0;
  }
  for (const auto& edge : mesh.edges) {
    for (const std::uint32_t v : edge) numbers[v] = 0;
  }
  std::uint32_t next = 0;
  for (std::uint32_t& number : numbers) {
    if (number == 0) number = next++;
  }
  return numbers;
}

template <class Row>
void keep_rows(const std::vector<std::uint32_t>& numbers, std::size_t length, std::vector<Row>& rows) {
  std::size_t to = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] == kUnused) continue;
    for (std::size_t c = 0; c < length; ++c) rows[to++] = rows[i * length + c];
  }
  rows.resize(to);
}

void keep_points(const std::vector<std::uint32_t>& numbers, std::vector<std::uint32_t>& points) {
  std::erase_if(points, [&](std::uint32_t v) { return numbers[v] == kUnused; });
  for (std::uint32_t& v : points) v = numbers[v];
}

}  // namespace

void keep_part_of_corners(const MeshRange& range, MeshData& mesh) {
  std::vector<std::uint32_t>& corners = mesh.corners;
  const auto begin = static_cast<std::ptrdiff_t>(range.part_begin(corners.size()));
  const auto end = static_cast<std::ptrdiff_t>(range.part_end(corners.size()));
  corners = std::vector<std::uint32_t>(corners.begin() + begin, corners.begin() + end);
}

std::string RefNames::name(int dimension, std::int32_t ref) const {
  const auto found = names_.find({dimension, ref});
  std::string name(found == names_.end() ? std::string_view() : trimmed(found->second));
  if (name.empty()) return std::string(kDefaultName) + std::to_string(ref);
  std::ranges::replace_if(
      name, [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return name;
}

std::int32_t RefNumbering::ref(std::string_view name) {
  const auto known = refs_.find(name);
  if (known != refs_.end()) return known->second;
  std::int32_t ref = 0;
  const bool numbered = numbered_name(name, ref) && !taken_.contains(ref);
  if (!numbered) {
    while (taken_.contains(next_)) ++next_;
    ref = next_;
    if (!name.empty()) names_.set(dimension_, ref, std::string(name));
  }
  taken_.insert(ref);
  refs_.emplace(name, ref);
  return ref;
}

void MeshContents::drop(const std::string& what, std::uint64_t count) {
  if (count == 0) return;
  const auto known = std::ranges::find(dropped, what, &Dropped::what);
  if (known == dropped.end()) {
    dropped.push_back({what, count});
  } else {
    known->count += count;
  }
}

void MeshContents::complete() {
  mesh.point_refs.resize(mesh.points.size());
  mesh.tet_refs.resize(mesh.tets.size());
  mesh.triangle_refs.resize(mesh.triangles.size());
  mesh.edge_refs.resize(mesh.edges.size());
  fields.num_points = mesh.points.size();
}

MeshContents surface_of(const MeshView& contents) {
  MeshContents surface{contents.mesh, contents.fields, contents.names, {}, 0};
  MeshData& mesh = surface.mesh;
  if (mesh.tets.empty()) return surface;
  const std::vector<std::uint32_t> numbers = surface_numbers(mesh);
  mesh.tets.clear();
  mesh.tet_refs.clear();
  keep_rows(numbers, 1, mesh.points);
  keep_rows(numbers, 1, mesh.point_refs);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) v = numbers[v];
  }
  for (auto& edge : mesh.edges) {
    for (std::uint32_t& v : edge) v = numbers[v];
  }
  keep_points(numbers, mesh.corners);
  keep_points(numbers, mesh.required_points);
  for (Field& field : surface.fields.fields) {
    keep_rows(numbers, static_cast<std::size_t>(components(field.kind)), field.values);
  }
  surface.fields.num_points = mesh.points.size();
  return surface;
}

bool fold_full_tensors(const std::vector<double>& full, std::vector<double>& folded) {
  // Other programs' rounding of the two halves is no asymmetry.
  constexpr double kRounding = 1e-6;
  folded.resize(full.size() / 9 * 6);
  for (std::size_t i = 0; i * 9 < full.size(); ++i) {
    double largest = 0;
    for (std::size_t c = 0; c < 9; ++c) {
      folded[6 * i + static_cast<std::size_t>(kFullTensorPlaces[c])] = full[9 * i + c];
      largest = std::max(largest, std::abs(full[9 * i + c]));
    }
    for (std::size_t c = 0; c < 9; ++c) {
      const double here = folded[6 * i + static_cast<std::size_t>(kFullTensorPlaces[c])];
      if (std::abs(here - full[9 * i + c]) > kRounding * largest) return false;
    }
  }
  return true;
}

std::string field_name(const SolutionData& fields, std::size_t i) {
  const std::string& name = fields.fields[i].name;
  return name.empty() ? "field_" + std::to_string(i + 1) : name;
}

std::string UniqueNames::unique(const std::string& name) {
  constexpr const char* kNoEnd[] = {""};
  return unique_begin(name, kNoEnd);
}

std::string UniqueNames::unique_begin(const std::string& name, std::span<const char* const> ends) {
  std::size_t room = longest_;
  for (const std::string_view end : ends) room = std::min(room, longest_ - end.size());
  std::string begin = first_characters(name, room);
  const auto taken = [&](const char* end) { return taken_.contains(begin + end); };
  for (int i = 2; std::ranges::any_of(ends, taken); ++i) {
    const std::string number = "_" + std::to_string(i);
    begin = first_characters(name, room - number.size()) + number;
  }
  for (const char* end : ends) taken_.insert(begin + end);
  return begin;
}

bool has_refs(const std::vector<std::int32_t>& refs) {
  return std::ranges::any_of(refs, [](std::int32_t ref) { return ref != 0; });
}

std::map<std::int32_t, std::vector<std::uint32_t>> indices_by_ref(const std::vector<std::int32_t>& refs) {
  std::map<std::int32_t, std::vector<std::uint32_t>> indices;
  for (std::size_t i = 0; i < refs.size(); ++i) indices[refs[i]].push_back(static_cast<std::uint32_t>(i));
  return indices;
}

void check_lengths(const MeshData& mesh, const SolutionData& fields) {
  if (mesh.point_refs.size() != mesh.points.size() || mesh.tet_refs.size() != mesh.tets.size() ||
      mesh.triangle_refs.size() != mesh.triangles.size() || mesh.edge_refs.size() != mesh.edges.size()) {
    throw std::logic_error("writing a mesh: an entity array and its references differ in length");
  }
  for (const Field& field : fields.fields) {
    if (field.values.size() != mesh.points.size() * static_cast<std::size_t>(components(field.kind))) {
      throw std::logic_error("writing a mesh: a field's values do not match the number of points");
    }
  }
}

}  // namespace weft::meshing
