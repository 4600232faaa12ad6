// GMF in three parts: the sections of a file (binary, text), what is read from their rows, and the writers.
// Facts of the format follow libMeshb (https://github.com/LoicMarechal/libMeshb).
#include "meshing/io/gmf.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/error.h"
#include "meshing/io/atomic_file.h"
#include "meshing/io/byte_order.h"
#include "meshing/io/input_file.h"
#include "meshing/io/text_numbers.h"

namespace weft::meshing {
namespace {

constexpr std::int64_t kMaxInt32 = std::numeric_limits<std::int32_t>::max();
/// The largest entity count that 32-bit ids with one invalid value can number.
constexpr std::uint64_t kMaxEntities = 0xFFFFFFFEu;

enum Keyword : std::int32_t {
  kDimension = 3,
  kVertices = 4,
  kEdges = 5,
  kTriangles = 6,
  kTetrahedra = 8,
  kCorners = 13,
  kRidges = 14,
  kRequiredVertices = 15,
  kRequiredEdges = 16,
  kRequiredTriangles = 17,
  kEnd = 54,
  kSolAtVertices = 62,
  kFloatingPointPrecision = 155,
};

struct KeywordInfo {
  std::int32_t code;
  std::string_view name;
  bool foreign_volume = false;  ///< volume elements that a tetrahedral mesh cannot keep
};

/// All keywords that mean something here; others are skipped.
constexpr KeywordInfo kKeywords[] = {
    {kVertices, "Vertices"},
    {kEdges, "Edges"},
    {kTriangles, "Triangles"},
    {kTetrahedra, "Tetrahedra"},
    {kCorners, "Corners"},
    {kRidges, "Ridges"},
    {kRequiredVertices, "RequiredVertices"},
    {kRequiredEdges, "RequiredEdges"},
    {kRequiredTriangles, "RequiredTriangles"},
    {kSolAtVertices, "SolAtVertices"},
    {9, "Prisms", true},
    {10, "Hexahedra", true},
    {30, "TetrahedraP2", true},
    {33, "HexahedraQ2", true},
    {46, "Polyhedra", true},
    {49, "Pyramids", true},
    {86, "PrismsP2", true},
    {87, "PyramidsP2", true},
    {96, "TetrahedraP3", true},
    {97, "TetrahedraP4", true},
    {98, "HexahedraQ3", true},
    {99, "HexahedraQ4", true},
    {100, "PyramidsP3", true},
    {101, "PyramidsP4", true},
    {102, "PrismsP3", true},
    {103, "PrismsP4", true},
    {200, "Prisms9", true},
    {201, "Hexahedra12", true},
    {207, "PolyhedraHeaders", true},
};

template <class Key>
const KeywordInfo* find_keyword(Key KeywordInfo::*member, const std::type_identity_t<Key>& key) {
  const auto found = std::ranges::find(kKeywords, key, member);
  return found == std::end(kKeywords) ? nullptr : found;
}

std::string_view keyword_name(Keyword code) { return find_keyword(&KeywordInfo::code, code)->name; }

/// Where the rows of one keyword lie in the file.
struct Section {
  const KeywordInfo* keyword;
  std::uint64_t count;       ///< rows it claims to have
  std::uint64_t begin, end;  ///< bytes, from behind the count to the next keyword
};

/// The sections of one file that mean something here, each at most once.
class SectionTable {
 public:
  void add(const std::string& file, Section section) {
    if (find(section.keyword->code))
      throw InputError(file, std::string(section.keyword->name), "appears twice");
    if (section.count > kMaxEntities) {
      throw InputError(
          file, std::string(section.keyword->name),
          std::to_string(section.count) + " entities exceed the limit of " + std::to_string(kMaxEntities));
    }
    sections_.push_back(section);
  }
  const Section* find(std::int32_t code) const {
    const auto found = std::ranges::find(sections_, code, [](const Section& s) { return s.keyword->code; });
    return found == sections_.end() ? nullptr : &*found;
  }
  std::span<const Section> all() const { return sections_; }

 private:
  std::vector<Section> sections_;
};

void check_dimension(const std::string& file, std::int64_t dimension) {
  if (dimension == 2) throw InputError(file, "Dimension", "the mesh is two-dimensional; weft adapts volumes");
  if (dimension != 3) throw InputError(file, "Dimension", std::to_string(dimension) + " instead of 3");
}

// ---------------------------------------------------------------------------------------------------------
// Binary files

/// How numbers are stored: sizes in bytes by version, and the byte order.
struct Encoding {
  int version = 2;
  bool swapped = false;
  std::size_t real_size = 8;

  explicit Encoding(int v, bool s = false) : version(v), swapped(s), real_size(v == 1 ? 4 : 8) {}
  std::size_t index_size() const { return version >= 4 ? 8 : 4; }
  std::size_t position_size() const { return version >= 3 ? 8 : 4; }
  std::uint64_t row_size(std::size_t reals, std::size_t indices) const {
    return reals * real_size + indices * index_size();
  }
};

std::int64_t load_int(const std::byte* from, std::size_t size, bool swapped) {
  if (size == 8) return load<std::int64_t>(from, swapped);
  return load<std::int32_t>(from, swapped);
}

double load_real(const std::byte* from, std::size_t size, bool swapped) {
  if (size == 8) return load<double>(from, swapped);
  return load<float>(from, swapped);
}

/// Reads the rows of one section in order, through a buffer.
class BinaryRows {
 public:
  BinaryRows(const InputFile& file, const Encoding& encoding, const Section& section, std::size_t reals,
             std::size_t indices)
      : file_(file), encoding_(encoding), section_(section), row_size_(encoding.row_size(reals, indices)) {
    const std::uint64_t bytes = section.end - section.begin;
    // Division first: the product of a damaged count may overflow.
    if (section.count > bytes / row_size_ || section.count * row_size_ != bytes) {
      throw InputError(file.name(), std::string(section.keyword->name),
                       std::to_string(section.count) + " rows of " + std::to_string(row_size_) +
                           " bytes do not fill the section's " + std::to_string(bytes) + " bytes");
    }
    capacity_ = std::min(bytes, std::max(row_size_, kBufferSize / row_size_ * row_size_));
    buffer_ = std::make_unique_for_overwrite<std::byte[]>(capacity_);
  }

  void begin_row() {
    ++row_;
    if (next_ == filled_) refill();
  }
  double real() { return load_real(advance(encoding_.real_size), encoding_.real_size, encoding_.swapped); }
  std::int64_t integer() {
    return load_int(advance(encoding_.index_size()), encoding_.index_size(), encoding_.swapped);
  }
  void finish() const {}

  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_.name(), std::string(section_.keyword->name) + " " + std::to_string(row_), reason);
  }

 private:
  static constexpr std::uint64_t kBufferSize = std::uint64_t{1} << 20;

  const std::byte* advance(std::size_t size) {
    const std::byte* at = buffer_.get() + next_;
    next_ += size;
    return at;
  }
  void refill() {
    filled_ = std::min(capacity_, section_.end - section_.begin - consumed_);
    file_.read_at(section_.begin + consumed_, buffer_.get(), filled_);
    consumed_ += filled_;
    next_ = 0;
  }

  const InputFile& file_;
  const Encoding encoding_;
  const Section section_;
  const std::uint64_t row_size_;
  std::unique_ptr<std::byte[]> buffer_;
  std::uint64_t capacity_ = 0, filled_ = 0, next_ = 0;  ///< of the buffer; whole rows
  std::uint64_t consumed_ = 0;                          ///< bytes of the section read so far
  std::uint64_t row_ = 0;                               ///< 1-based, for messages
};

/// A binary file: its header, and its chain of keywords cut into sections.
class BinaryFile {
 public:
  explicit BinaryFile(const std::filesystem::path& path) : file_(path), encoding_(read_header(file_)) {
    std::uint64_t position = 8;
    while (const std::optional<std::uint64_t> next = scan_keyword(position)) position = *next;
    if (!has_dimension_) throw InputError(name(), "Dimension", "is missing");
  }

  const std::string& name() const { return file_.name(); }
  const SectionTable& sections() const { return sections_; }
  BinaryRows rows(const Section& section, std::size_t reals, std::size_t indices) const {
    return BinaryRows(file_, encoding_, section, reals, indices);
  }

  /// The types of the fields in a solution section; moves the section's begin to its first row.
  std::vector<std::int64_t> take_solution_types(Section& section) const {
    const std::int64_t count = section.end - section.begin < 4 ? -1 : int_at(section.begin, 4);
    if (count < 0 || static_cast<std::uint64_t>(count) > (section.end - section.begin - 4) / 4) {
      throw InputError(name(), std::string(section.keyword->name), "the number of fields is damaged");
    }
    std::vector<std::int64_t> types(static_cast<std::size_t>(count));
    section.begin += 4;
    for (std::int64_t& type : types) {
      type = int_at(section.begin, 4);
      section.begin += 4;
    }
    return types;
  }

 private:
  static Encoding read_header(const InputFile& file) {
    std::array<std::byte, 8> header;
    if (file.size() < header.size()) throw InputError(file.name(), "", "too short for a binary GMF file");
    file.read_at(0, header.data(), header.size());
    const auto code = load<std::uint32_t>(header.data(), false);
    if (code != 1 && code != 0x01000000u) {
      throw InputError(file.name(), "", "not a binary GMF file (its first word is neither 1 nor 1 swapped)");
    }
    const std::int64_t version = load_int(header.data() + 4, 4, code != 1);
    if (version < 1 || version > 4) {
      throw InputError(file.name(), "",
                       "GMF version " + std::to_string(version) + " is unknown (1 to 4 are)");
    }
    return Encoding(static_cast<int>(version), code != 1);
  }

  std::int64_t int_at(std::uint64_t position, std::size_t size) const {
    std::array<std::byte, 8> bytes;
    file_.read_at(position, bytes.data(), size);
    return load_int(bytes.data(), size, encoding_.swapped);
  }

  /// Notes the keyword at `position`; returns where the next one is, nothing at the End.
  std::optional<std::uint64_t> scan_keyword(std::uint64_t position) {
    const std::uint64_t begin = position + 4 + encoding_.position_size();
    if (begin > file_.size()) throw InputError(name(), "", "the file is truncated: no keyword End");
    const std::int64_t code = int_at(position, 4);
    if (code == kEnd) return std::nullopt;
    const auto next = static_cast<std::uint64_t>(int_at(position + 4, encoding_.position_size()));
    // Forward only, which also rules out cycles and a chain that stops (position 0) without End.
    if (next < begin || next > file_.size()) {
      throw InputError(name(), describe(code),
                       "the next keyword's position " + std::to_string(static_cast<std::int64_t>(next)) +
                           " is not in " + std::to_string(begin) + ".." + std::to_string(file_.size()) +
                           ": the file is truncated or damaged");
    }
    note_keyword(code, begin, next);
    return next;
  }

  void note_keyword(std::int64_t code, std::uint64_t begin, std::uint64_t end) {
    if (code == kDimension || code == kFloatingPointPrecision) {
      if (end - begin < 4) throw InputError(name(), describe(code), "its value is missing");
      note_value(code, int_at(begin, 4));
    } else if (const KeywordInfo* keyword =
                   find_keyword(&KeywordInfo::code, static_cast<std::int32_t>(code))) {
      const std::size_t size = encoding_.index_size();
      if (end - begin < size) throw InputError(name(), describe(code), "its count is missing");
      const std::int64_t count = int_at(begin, size);
      if (count < 0) throw InputError(name(), describe(code), "its count is negative");
      sections_.add(name(), {keyword, static_cast<std::uint64_t>(count), begin + size, end});
    }
  }

  void note_value(std::int64_t code, std::int64_t value) {
    if (code == kDimension) {
      if (has_dimension_) throw InputError(name(), "Dimension", "appears twice");
      check_dimension(name(), value);
      has_dimension_ = true;
    } else if (value == 32 || value == 64) {
      encoding_.real_size = static_cast<std::size_t>(value / 8);
    }
  }

  static std::string describe(std::int64_t code) {
    const KeywordInfo* keyword = find_keyword(&KeywordInfo::code, static_cast<std::int32_t>(code));
    return keyword ? std::string(keyword->name) : "keyword " + std::to_string(code);
  }

  InputFile file_;
  Encoding encoding_;
  SectionTable sections_;
  bool has_dimension_ = false;
};

// ---------------------------------------------------------------------------------------------------------
// Text files

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Cuts text into words; a '#' begins a comment that lasts to the end of the line.
class Words {
 public:
  Words(std::string_view text, std::uint64_t begin) : text_(text), at_(begin) {}

  /// The next word, empty at the end of the text.
  std::string_view next() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '#') ++at_;
    return text_.substr(begin, at_ - begin);
  }
  std::uint64_t position() const { return at_; }

 private:
  void skip_blanks() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (is_space(text_[at_])) {
        ++at_;
      } else {
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_;
};

/// Reads the rows of one section in order: the counterpart of BinaryRows.
class TextRows {
 public:
  TextRows(const std::string& file, std::string_view text, const Section& section, std::size_t reals,
           std::size_t indices)
      : file_(file), section_(section), words_(text, section.begin) {
    // Every number takes a digit and a blank, which bounds what a damaged count can make us allocate.
    const std::uint64_t most = (text.size() - section.begin + 1) / 2 / (reals + indices);
    if (section.count > most) {
      throw InputError(file, std::string(section.keyword->name),
                       std::to_string(section.count) + " rows are more than the file can hold");
    }
  }

  void begin_row() { ++row_; }
  double real() {
    const std::string_view word = words_.next();
    const std::optional<double> value = parse_real(word);
    if (!value) fail("expected a number, found " + quoted(word));
    return *value;
  }
  std::int64_t integer() {
    const std::string_view word = words_.next();
    const std::optional<std::int64_t> value = parse_integer(word);
    if (!value) fail("expected an integer, found " + quoted(word));
    return *value;
  }
  /// Rows beyond the count mean that the count is wrong.
  void finish() {
    const std::string_view word = words_.next();
    if (words_.position() > section_.end) return;
    throw InputError(file_, std::string(section_.keyword->name),
                     "there are more values than its count of " + std::to_string(section_.count) +
                         " rows needs: found " + quoted(word));
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_, std::string(section_.keyword->name) + " " + std::to_string(row_), reason);
  }

 private:
  const std::string& file_;
  const Section section_;
  Words words_;
  std::uint64_t row_ = 0;
};

/// Whether a word is a keyword (known or not) rather than a value.
bool is_keyword(std::string_view word) {
  return !word.empty() && is_letter(word.front()) && !parse_real(word);  // nan and inf are values
}

/// An ASCII file: read whole, and cut into sections at the words that are keywords.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path) : file_(path) { scan(); }

  const std::string& name() const { return file_.name(); }
  const SectionTable& sections() const { return sections_; }
  TextRows rows(const Section& section, std::size_t reals, std::size_t indices) const {
    return TextRows(name(), text(), section, reals, indices);
  }

  /// The types of the fields in a solution section; moves the section's begin to its first row.
  std::vector<std::int64_t> take_solution_types(Section& section) const {
    const std::string entity(section.keyword->name);
    Words words(text(), section.begin);
    const std::uint64_t count = next_count(words, entity, "a number of fields");
    if (count > text().size()) throw InputError(name(), entity, "the number of fields is damaged");
    std::vector<std::int64_t> types(count);
    for (std::int64_t& type : types) {
      type = static_cast<std::int64_t>(next_count(words, entity, "a field's type"));
    }
    section.begin = words.position();
    return types;
  }

 private:
  std::string_view text() const { return file_.bytes(); }

  std::uint64_t next_count(Words& words, const std::string& entity, const std::string& expected) const {
    const std::string_view word = words.next();
    const std::optional<std::int64_t> value = parse_integer(word);
    if (!value || *value < 0)
      throw InputError(name(), entity, "expected " + expected + ", found " + quoted(word));
    return static_cast<std::uint64_t>(*value);
  }

  void scan() {
    Words words(text(), 0);
    if (words.next() != "MeshVersionFormatted") {
      throw InputError(name(), "", "not an ASCII GMF file (it does not begin with MeshVersionFormatted)");
    }
    const std::uint64_t version = next_count(words, "MeshVersionFormatted", "a version");
    if (version < 1 || version > 4) {
      throw InputError(name(), "", "GMF version " + std::to_string(version) + " is unknown (1 to 4 are)");
    }
    std::string_view word = words.next();
    while (word != "End") {
      if (word.empty()) throw InputError(name(), "", "the file is truncated: no keyword End");
      word = scan_keyword(word, words);
    }
    if (!has_dimension_) throw InputError(name(), "Dimension", "is missing");
  }

  /// Notes a keyword; passes over its values and returns the word behind them.
  std::string_view scan_keyword(std::string_view word, Words& words) {
    const KeywordInfo* keyword = find_keyword(&KeywordInfo::name, word);
    const std::string entity(word);
    Section section{keyword, 0, 0, 0};
    if (word == "Dimension") {
      if (std::exchange(has_dimension_, true)) throw InputError(name(), entity, "appears twice");
      check_dimension(name(), static_cast<std::int64_t>(next_count(words, entity, "a dimension")));
    } else if (keyword) {
      section.count = next_count(words, entity, "a count");
    }
    section.begin = section.end = words.position();
    for (word = words.next(); !word.empty() && !is_keyword(word); word = words.next()) {
      section.end = words.position();
    }
    if (keyword) sections_.add(name(), section);
    return word;
  }

  FileBytes file_;
  SectionTable sections_;
  bool has_dimension_ = false;
};

// ---------------------------------------------------------------------------------------------------------
// What is read, from files of either kind

/// A 1-based index of one of `limit` entities, as a 0-based one.
template <class Rows>
std::uint32_t read_index(Rows& rows, std::uint64_t limit, const char* entity) {
  const std::int64_t index = rows.integer();
  if (index < 1 || static_cast<std::uint64_t>(index) > limit) {
    const std::string what = std::string(entity) + " index " + std::to_string(index);
    rows.fail(limit == 0 ? what + ", but the file has none"
                         : what + " is out of range 1.." + std::to_string(limit));
  }
  return static_cast<std::uint32_t>(index - 1);
}

template <class Rows>
std::int32_t read_ref(Rows& rows) {
  const std::int64_t ref = rows.integer();
  if (ref < -kMaxInt32 - 1 || ref > kMaxInt32) {
    rows.fail("reference " + std::to_string(ref) + " does not fit 32 bits");
  }
  return static_cast<std::int32_t>(ref);
}

template <class File>
void read_vertices(const File& file, MeshData& mesh) {
  const Section* section = file.sections().find(kVertices);
  if (!section) throw InputError(file.name(), "Vertices", "are missing");
  auto rows = file.rows(*section, 3, 1);
  mesh.points.resize(section->count);
  mesh.point_refs.resize(section->count);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    rows.begin_row();
    Point& p = mesh.points[i];
    for (int c = 0; c < 3; ++c) {
      p[c] = rows.real();
      if (!std::isfinite(p[c])) rows.fail("a coordinate is not finite");
    }
    mesh.point_refs[i] = read_ref(rows);
  }
  rows.finish();
}

template <std::size_t N, class File>
void read_elements(const File& file, Keyword code, std::size_t num_points,
                   std::vector<std::array<std::uint32_t, N>>& elements, std::vector<std::int32_t>& refs) {
  const Section* section = file.sections().find(code);
  if (!section) return;
  auto rows = file.rows(*section, 0, N + 1);
  elements.resize(section->count);
  refs.resize(section->count);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    rows.begin_row();
    for (std::uint32_t& vertex : elements[i]) vertex = read_index(rows, num_points, "vertex");
    refs[i] = read_ref(rows);
  }
  rows.finish();
}

template <class File>
void read_indices(const File& file, Keyword code, std::size_t limit, const char* entity,
                  std::vector<std::uint32_t>& indices) {
  const Section* section = file.sections().find(code);
  if (!section) return;
  auto rows = file.rows(*section, 0, 1);
  indices.resize(section->count);
  for (std::uint32_t& index : indices) {
    rows.begin_row();
    index = read_index(rows, limit, entity);
  }
  rows.finish();
}

template <class File>
MeshData read_mesh_of(const File& file) {
  for (const Section& section : file.sections().all()) {
    if (section.keyword->foreign_volume && section.count > 0) {
      throw InputError(
          file.name(), std::string(section.keyword->name),
          "the mesh has " + std::to_string(section.count) + " of them; weft adapts linear tetrahedra only");
    }
  }
  MeshData mesh;
  read_vertices(file, mesh);
  const std::size_t num_points = mesh.points.size();
  read_elements(file, kTetrahedra, num_points, mesh.tets, mesh.tet_refs);
  read_elements(file, kTriangles, num_points, mesh.triangles, mesh.triangle_refs);
  read_elements(file, kEdges, num_points, mesh.edges, mesh.edge_refs);
  read_indices(file, kCorners, num_points, "vertex", mesh.corners);
  read_indices(file, kRequiredVertices, num_points, "vertex", mesh.required_points);
  read_indices(file, kRidges, mesh.edges.size(), "edge", mesh.ridges);
  read_indices(file, kRequiredEdges, mesh.edges.size(), "edge", mesh.required_edges);
  read_indices(file, kRequiredTriangles, mesh.triangles.size(), "triangle", mesh.required_triangles);
  return mesh;
}

/// Empty fields of the kinds that a solution section announces.
std::vector<Field> make_fields(const std::string& file, const std::vector<std::int64_t>& types) {
  if (types.empty()) throw InputError(file, "SolAtVertices", "has no fields");
  std::vector<Field> fields;
  for (const std::int64_t type : types) {
    if (type < 1 || type > 3) {
      throw InputError(file, "SolAtVertices",
                       "field " + std::to_string(fields.size() + 1) + " has type " + std::to_string(type) +
                           "; known are 1 (scalar), 2 (vector) and 3 (symmetric tensor)");
    }
    fields.push_back({static_cast<Field::Kind>(type), {}, {}});
  }
  return fields;
}

template <class File>
SolutionData read_solution_of(const File& file) {
  const Section* found = file.sections().find(kSolAtVertices);
  if (!found) throw InputError(file.name(), "SolAtVertices", "is missing: no solution at vertices");
  Section section = *found;
  SolutionData solution;
  solution.fields = make_fields(file.name(), file.take_solution_types(section));
  std::size_t row_length = 0;
  for (const Field& field : solution.fields) row_length += components(field.kind);
  auto rows = file.rows(section, row_length, 0);
  solution.num_points = section.count;
  for (Field& field : solution.fields) field.values.resize(section.count * components(field.kind));
  for (std::size_t i = 0; i < solution.num_points; ++i) {
    rows.begin_row();
    for (Field& field : solution.fields) {
      const std::size_t length = components(field.kind);
      for (std::size_t c = 0; c < length; ++c) field.values[i * length + c] = rows.real();
    }
  }
  rows.finish();
  return solution;
}

// ---------------------------------------------------------------------------------------------------------
// Writing

/// The rows of one section to be written: what both writers need to know beforehand.
struct SectionShape {
  Keyword code;
  std::uint64_t count;
  std::size_t reals, indices;                  ///< a row
  std::vector<std::int32_t> field_types = {};  ///< of a solution
};

std::uint64_t section_size(const Encoding& encoding, const SectionShape& shape) {
  const bool solution = shape.code == kSolAtVertices;
  return 4 + encoding.position_size() + encoding.index_size() +
         (solution ? 4 * (1 + shape.field_types.size()) : 0) +
         shape.count * encoding.row_size(shape.reals, shape.indices);
}

std::uint64_t file_size(const Encoding& encoding, const std::vector<SectionShape>& shapes) {
  const std::uint64_t keyword = 4 + encoding.position_size();
  std::uint64_t size = 8 + (keyword + 4) + keyword;  // code and version, Dimension, End
  for (const SectionShape& shape : shapes) size += section_size(encoding, shape);
  return size;
}

bool version_holds(int version, const std::vector<SectionShape>& shapes) {
  const auto count_fits = [](const SectionShape& shape) { return shape.count <= kMaxInt32; };
  if (version < 4 && !std::ranges::all_of(shapes, count_fits)) return false;
  return version >= 3 || file_size(Encoding(version), shapes) <= kMaxInt32;
}

/// The version to write: the wanted one, or for 0 the one that most programs read.
int choose_version(const std::string& file, int wanted, const std::vector<SectionShape>& shapes) {
  if (wanted == 0) return version_holds(2, shapes) ? 2 : version_holds(3, shapes) ? 3 : 4;
  if (wanted < 1 || wanted > 4) {
    throw InputError(file, "", "cannot write GMF version " + std::to_string(wanted) + " (1 to 4 exist)");
  }
  if (!version_holds(wanted, shapes)) {
    throw InputError(file, "", "too large for GMF version " + std::to_string(wanted));
  }
  return wanted;
}

/// Writes binary rows in this machine's byte order.
class BinaryWriter {
 public:
  BinaryWriter(const std::filesystem::path& path, int version)
      : name_(path.string()), out_(path), encoding_(version) {
    out_.write_value<std::int32_t>(1);
    out_.write_value<std::int32_t>(version);
    begin_keyword(kDimension, out_.position() + 4 + encoding_.position_size() + 4);
    out_.write_value<std::int32_t>(3);
  }

  void begin_section(const SectionShape& shape) {
    begin_keyword(shape.code, out_.position() + section_size(encoding_, shape));
    index(shape.count);
    if (shape.code != kSolAtVertices) return;
    out_.write_value(static_cast<std::int32_t>(shape.field_types.size()));
    for (const std::int32_t type : shape.field_types) out_.write_value(type);
  }
  void real(double value) {
    if (encoding_.real_size == 8) return out_.write_value(value);
    if (std::isfinite(value) && std::abs(value) > std::numeric_limits<float>::max()) {
      throw InputError(name_, "", "a value is too large for the 32-bit reals of GMF version 1");
    }
    out_.write_value(static_cast<float>(value));
  }
  /// An index or a reference.
  void index(std::int64_t value) {
    if (encoding_.index_size() == 8) return out_.write_value(value);
    out_.write_value(static_cast<std::int32_t>(value));
  }
  void end_row() {}
  void finish() {
    begin_keyword(kEnd, 0);
    out_.commit();
  }

 private:
  void begin_keyword(Keyword code, std::uint64_t next) {
    out_.write_value<std::int32_t>(code);
    if (encoding_.position_size() == 8) return out_.write_value(next);
    out_.write_value(static_cast<std::uint32_t>(next));
  }

  std::string name_;
  AtomicFile out_;
  Encoding encoding_;
};

/// Writes the same as text; reals with as many digits as give them back exactly.
class TextWriter {
 public:
  TextWriter(const std::filesystem::path& path, int version) : out_(path) {
    out_.write("MeshVersionFormatted " + std::to_string(version) + "\n\nDimension 3\n");
  }

  void begin_section(const SectionShape& shape) {
    out_.write("\n" + std::string(keyword_name(shape.code)) + "\n" + std::to_string(shape.count) + "\n");
    if (shape.code != kSolAtVertices) return;
    out_.write(std::to_string(shape.field_types.size()));
    for (const std::int32_t type : shape.field_types) out_.write(" " + std::to_string(type));
    out_.write("\n");
  }
  void real(double value) { number(value); }
  void index(std::int64_t value) { number(value); }
  void end_row() {
    out_.write("\n");
    row_begins_ = true;
  }
  void finish() {
    out_.write("\nEnd\n");
    out_.commit();
  }

 private:
  template <class Number>
  void number(Number value) {
    std::array<char, 32> digits;  // the longest double has 24 characters
    char* begin = digits.data();
    if (!std::exchange(row_begins_, false)) *begin++ = ' ';
    const char* end = std::to_chars(begin, digits.data() + digits.size(), value).ptr;
    out_.write(digits.data(), static_cast<std::size_t>(end - digits.data()));
  }

  AtomicFile out_;
  bool row_begins_ = true;
};

/// The index lists of a mesh, with their keywords.
struct IndexList {
  Keyword code;
  const std::vector<std::uint32_t>& indices;
};
std::array<IndexList, 5> index_lists(const MeshData& mesh) {
  return {{{kCorners, mesh.corners},
           {kRidges, mesh.ridges},
           {kRequiredVertices, mesh.required_points},
           {kRequiredEdges, mesh.required_edges},
           {kRequiredTriangles, mesh.required_triangles}}};
}

/// The sections a mesh needs. Empty ones are left out, except the vertices without which nothing reads it.
std::vector<SectionShape> shapes_of(const MeshData& mesh) {
  std::vector<SectionShape> shapes{{kVertices, mesh.points.size(), 3, 1},
                                   {kEdges, mesh.edges.size(), 0, 3},
                                   {kTriangles, mesh.triangles.size(), 0, 4},
                                   {kTetrahedra, mesh.tets.size(), 0, 5}};
  for (const IndexList& list : index_lists(mesh)) shapes.push_back({list.code, list.indices.size(), 0, 1});
  std::erase_if(shapes, [](const SectionShape& s) { return s.count == 0 && s.code != kVertices; });
  return shapes;
}

void check_lengths(const MeshData& mesh) {
  if (mesh.point_refs.size() != mesh.points.size() || mesh.tet_refs.size() != mesh.tets.size() ||
      mesh.triangle_refs.size() != mesh.triangles.size() || mesh.edge_refs.size() != mesh.edges.size()) {
    throw std::logic_error("write_gmf_mesh: an entity array and its references differ in length");
  }
}

template <class Writer>
void write_vertices(Writer& out, const MeshData& mesh) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    for (int c = 0; c < 3; ++c) out.real(mesh.points[i][c]);
    out.index(mesh.point_refs[i]);
    out.end_row();
  }
}

template <class Writer, std::size_t N>
void write_elements(Writer& out, const std::vector<std::array<std::uint32_t, N>>& elements,
                    const std::vector<std::int32_t>& refs) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (const std::uint32_t vertex : elements[i]) out.index(std::int64_t{vertex} + 1);
    out.index(refs[i]);
    out.end_row();
  }
}

template <class Writer>
void write_indices(Writer& out, const MeshData& mesh, Keyword code) {
  for (const IndexList& list : index_lists(mesh)) {
    if (list.code != code) continue;
    for (const std::uint32_t index : list.indices) {
      out.index(std::int64_t{index} + 1);
      out.end_row();
    }
  }
}

template <class Writer>
void write_mesh_to(Writer&& out, const MeshData& mesh, const std::vector<SectionShape>& shapes) {
  for (const SectionShape& shape : shapes) {
    out.begin_section(shape);
    switch (shape.code) {
      case kVertices:
        write_vertices(out, mesh);
        break;
      case kEdges:
        write_elements(out, mesh.edges, mesh.edge_refs);
        break;
      case kTriangles:
        write_elements(out, mesh.triangles, mesh.triangle_refs);
        break;
      case kTetrahedra:
        write_elements(out, mesh.tets, mesh.tet_refs);
        break;
      default:
        write_indices(out, mesh, shape.code);
    }
  }
  out.finish();
}

SectionShape shape_of(const SolutionData& solution) {
  if (solution.fields.empty()) throw std::logic_error("write_gmf_solution: there is no field to write");
  SectionShape shape{kSolAtVertices, solution.num_points, 0, 0};
  for (const Field& field : solution.fields) {
    const auto length = static_cast<std::size_t>(components(field.kind));
    if (field.values.size() != solution.num_points * length) {
      throw std::logic_error("write_gmf_solution: a field's values do not match the number of points");
    }
    shape.reals += length;
    shape.field_types.push_back(static_cast<std::int32_t>(field.kind));
  }
  return shape;
}

template <class Writer>
void write_solution_to(Writer&& out, const SolutionData& solution, const SectionShape& shape) {
  out.begin_section(shape);
  for (std::size_t i = 0; i < solution.num_points; ++i) {
    for (const Field& field : solution.fields) {
      const std::size_t length = components(field.kind);
      for (std::size_t c = 0; c < length; ++c) out.real(field.values[i * length + c]);
    }
    out.end_row();
  }
  out.finish();
}

bool is_text(const std::filesystem::path& path) {
  return path.extension() == ".mesh" || path.extension() == ".sol";
}

}  // namespace

MeshData read_gmf_mesh(const std::filesystem::path& path) {
  return is_text(path) ? read_mesh_of(TextFile(path)) : read_mesh_of(BinaryFile(path));
}

SolutionData read_gmf_solution(const std::filesystem::path& path) {
  return is_text(path) ? read_solution_of(TextFile(path)) : read_solution_of(BinaryFile(path));
}

void write_gmf_mesh(const std::filesystem::path& path, const MeshData& mesh, int version) {
  check_lengths(mesh);
  const std::vector<SectionShape> shapes = shapes_of(mesh);
  version = choose_version(path.string(), version, shapes);
  if (is_text(path)) return write_mesh_to(TextWriter(path, version), mesh, shapes);
  write_mesh_to(BinaryWriter(path, version), mesh, shapes);
}

void write_gmf_solution(const std::filesystem::path& path, const SolutionData& solution, int version) {
  const SectionShape shape = shape_of(solution);
  version = choose_version(path.string(), version, {shape});
  if (is_text(path)) return write_solution_to(TextWriter(path, version), solution, shape);
  write_solution_to(BinaryWriter(path, version), solution, shape);
}

}  // namespace weft::meshing
