// The values pass by in blocks.
#include "tools/library/jobs/sources/field_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf_slice.h"
#include "meshing/io/mesh_file.h"
#include "tools/library/jobs/sources/field_source.h"
#include "tools/library/jobs/sources/shares.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using meshing::Field;
using meshing::PieceRange;
using meshing::PieceSize;

/// Vertices of a block. Of text and of compressed arrays each block passes over those before it.
constexpr std::uint64_t kBlock = std::uint64_t{1} << 20;

/// Counts the points, and nothing else.
class PointCounter final : public meshing::MeshStream {
 public:
  std::uint64_t points() const { return points_; }

  void take_points(std::vector<meshing::Point> rows) override { points_ += rows.size(); }

 private:
  std::uint64_t points_ = 0;
};

void add_piece(const PieceSize& size, VertexCount& count) {
  count.least = std::max(count.least, size.points);
  count.most += size.points;
}

VertexCount count_in_pieces(const std::string& file) {
  VertexCount count;
  for (const fs::path& source : meshing::piece_sources(file))
    for (const PieceSize& size : meshing::piece_sizes(source)) add_piece(size, count);
  return count;
}

/// One file of fields, of which no more than a block is held at a time.
class FieldCheck {
 public:
  FieldCheck(const std::string& file, const VertexCount& vertices, const std::string& mesh)
      : file_(file), vertices_(vertices), mesh_(mesh) {}

  Fields solution() const {
    const meshing::GmfLayout layout = meshing::read_gmf_layout(file_);
    const std::uint64_t total = layout.num_solution_points();
    check_length({total, total});
    Fields heads = meshing::read_gmf_solution_slice(file_, layout, 0, 0);
    if (heads.fields.empty()) throw InputError(file_, "", "has no fields");
    for (std::uint64_t first = 0; first < total; first += kBlock)
      check_values(file_,
                   meshing::read_gmf_solution_slice(file_, layout, first, std::min(kBlock, total - first)),
                   first);
    return heads;
  }

  Fields pieces() const {
    const std::vector<fs::path> sources = meshing::piece_sources(file_);
    std::vector<std::vector<PieceSize>> sizes;
    VertexCount count;
    for (const fs::path& source : sources) {
      sizes.push_back(meshing::piece_sizes(source));
      for (const PieceSize& size : sizes.back()) add_piece(size, count);
    }
    check_length(count);
    std::optional<Fields> common;
    for (std::size_t s = 0; s < sources.size(); ++s)
      for (meshing::MeshContents& piece : read_block(sources[s], sizes[s], 0, 0))
        keep_common(std::move(piece.fields), common);
    if (!common) return {};
    for (std::size_t s = 0; s < sources.size(); ++s) check_source(sources[s], sizes[s], *common);
    return std::move(*common);
  }

  Fields streamed() const;

  Fields whole() const {
    Fields fields = meshing::read_solution(file_);
    check_length({fields.num_points, fields.num_points});
    check_values(file_, fields);
    for (Field& field : fields.fields) field.values = {};
    return fields;
  }

  void check_length(const VertexCount& count) const {
    if (count.most < vertices_.least || count.least > vertices_.most)
      throw InputError(file_, "", of_another_mesh(count, mesh_, vertices_));
  }
  const std::string& file() const { return file_; }

 private:
  /// Of the vertices of a source, piece after piece, `count` from `first` on.
  static std::vector<meshing::MeshContents> read_block(const fs::path& source,
                                                       const std::vector<PieceSize>& sizes,
                                                       std::uint64_t first, std::uint64_t count) {
    std::vector<PieceRange> ranges;
    std::uint64_t before = 0;
    for (const PieceSize& size : sizes) {
      const std::uint64_t begin = std::clamp(first, before, before + size.points);
      const std::uint64_t end = std::clamp(first + count, before, before + size.points);
      ranges.push_back({.rows = {.first_point = begin - before, .num_points = end - begin}, .others = false});
      before += size.points;
    }
    return meshing::read_piece_fields(source, ranges);
  }

  static bool has(const Fields& fields, const Field& head) {
    return std::ranges::any_of(fields.fields,
                               [&](const Field& f) { return f.kind == head.kind && f.name == head.name; });
  }

  /// A field that a piece lacks the mesh does not have.
  static void keep_common(Fields heads, std::optional<Fields>& common) {
    if (!common)
      common = std::move(heads);
    else
      std::erase_if(common->fields, [&](const Field& head) { return !has(heads, head); });
  }

  void check_source(const fs::path& source, const std::vector<PieceSize>& sizes, Fields& common) const {
    std::uint64_t total = 0;
    for (const PieceSize& size : sizes) total += size.points;
    for (std::uint64_t first = 0; first < total; first += kBlock) {
      std::uint64_t before = 0;
      std::vector<meshing::MeshContents> block = read_block(source, sizes, first, kBlock);
      for (std::size_t p = 0; p < block.size(); ++p) {
        check_piece(source, sizes.size() > 1 ? fmt::format("piece {}, ", p + 1) : "", block[p].fields,
                    std::max(first, before) - before, common);
        before += sizes[p].points;
      }
    }
  }

  void check_piece(const fs::path& source, const std::string& piece, Fields& values, std::uint64_t first,
                   Fields& common) const {
    if (values.num_points == 0) return;
    for (const Field& field : values.fields)
      if (field.values.empty())  // no symmetric tensors
        std::erase_if(common.fields,
                      [&](const Field& head) { return head.kind == field.kind && head.name == field.name; });
    std::erase_if(values.fields, [&](const Field& field) { return !has(common, field); });
    check_values(source.string(), values, first, piece);
  }

  const std::string& file_;
  const VertexCount& vertices_;
  const std::string& mesh_;
};

/// What is wrong with a field that turns out to be none is nobody's business: that waits for its end.
class StreamCheck final : public meshing::FieldStream {
 public:
  explicit StreamCheck(const FieldCheck& check) : check_(check) {}

  void begin(const std::string& name, std::uint64_t length, std::uint64_t points) override {
    check_.check_length({points, points});
    head_ = {Field::Kind::scalar, {}, name};
    if (length > 1) head_.kind = length < 9 ? Field::Kind::vector : Field::Kind::tensor;
    length_ = length;
    given_.assign(points, false);
    is_symmetric_ = true;
    fault_.reset();
  }

  void take(std::vector<std::uint32_t> points, std::vector<double> values) override {
    for (const std::uint32_t point : points) given_[point] = true;
    std::vector<double> folded;
    if (length_ == 9) is_symmetric_ = is_symmetric_ && meshing::fold_full_tensors(values, folded);
    const auto bad = std::ranges::find_if(values, [](double x) { return !std::isfinite(x); });
    if (bad != values.end() && !fault_)
      fault_ = points[static_cast<std::uint64_t>(bad - values.begin()) / length_];
  }

  void end() override {
    if (!is_symmetric_ || std::ranges::find(given_, false) != given_.end()) return;
    heads_.fields.push_back(head_);
    if (fault_) throw not_finite(check_.file(), heads_.fields.size(), *fault_);
  }

  void drop(const std::string&) override {}

  Fields take_heads() { return std::move(heads_); }

 private:
  const FieldCheck& check_;
  Field head_;
  std::uint64_t length_ = 1;
  std::vector<bool> given_;
  bool is_symmetric_ = true;
  std::optional<std::uint64_t> fault_;  ///< the vertex of a value that is no number
  Fields heads_;
};

Fields FieldCheck::streamed() const {
  StreamCheck stream(*this);
  meshing::stream_fields(file_, stream);
  return stream.take_heads();
}

}  // namespace

VertexCount count_vertices_of(const std::string& mesh) {
  if (const std::optional<meshing::MeshSize> size = meshing::size_for_ranges(mesh))
    return {size->points, size->points};
  if (meshing::can_be_in_pieces(mesh)) return count_in_pieces(mesh);
  PointCounter counter;
  if (!meshing::can_be_streamed(mesh)) {
    const std::uint64_t points = meshing::read_mesh(mesh).points.size();
    return {points, points};
  }
  meshing::stream_mesh(mesh, counter);
  return {counter.points(), counter.points()};
}

Fields check_field_file(const std::string& file, const VertexCount& vertices, const std::string& mesh) {
  const FieldCheck check(file, vertices, mesh);
  if (!fields_in_shares(file)) return check.whole();
  if (!meshing::is_mesh_name(file)) return check.solution();
  Fields fields = meshing::can_stream_fields(file) ? check.streamed() : check.pieces();
  if (fields.fields.empty()) throw InputError(file, "", "holds no fields at vertices");
  return fields;
}

}  // namespace weft::tools
