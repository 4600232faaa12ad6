// pugixml reads the text but for the values of arrays, which are read by position, as what is appended is.
#include "meshing/io/vtk/vtk_xml.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/files/byte_order.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/text_output.h"

namespace weft::meshing {
namespace {

constexpr std::uint64_t kReadAtOnce = std::uint64_t{1} << 16;    ///< values of arrays that are no text
constexpr std::uint64_t kMostReserved = std::uint64_t{1} << 27;  ///< values, before any has been read

/// Calls f with a value of the C++ type that VTK calls `name`; false for an unknown name.
template <class F>
bool with_type(std::string_view name, const F& f) {
  if (name == "Int8") return f(std::int8_t{}), true;
  if (name == "UInt8") return f(std::uint8_t{}), true;
  if (name == "Int16") return f(std::int16_t{}), true;
  if (name == "UInt16") return f(std::uint16_t{}), true;
  if (name == "Int32") return f(std::int32_t{}), true;
  if (name == "UInt32") return f(std::uint32_t{}), true;
  if (name == "Int64") return f(std::int64_t{}), true;
  if (name == "UInt64") return f(std::uint64_t{}), true;
  if (name == "Float32") return f(float{}), true;
  if (name == "Float64") return f(double{}), true;
  return false;
}

std::string array_name(pugi::xml_node array) {
  const std::string name = array.attribute("Name").value();
  return name.empty() ? "a DataArray" : "array " + name;
}

/// Whether its values are words.
bool is_text(pugi::xml_node array) {
  const std::string_view format = array.attribute("format").value();
  return format == "ascii" || format.empty();
}

}  // namespace

// ---------------------------------------------------------------------------------------------------------
// Reading

VtkDocument::VtkDocument(const std::filesystem::path& path, const std::string& type) : file_(path) {
  read_text();
  const pugi::xml_parse_result parsed = xml_.load_buffer(text_.data(), text_.size());
  if (!parsed) {
    fail("", std::string("not XML, or truncated: ") + parsed.description() + " at byte " +
                 std::to_string(parsed.offset));
  }
  std::string().swap(text_);  // the document has a copy
  const pugi::xml_node root = xml_.child("VTKFile");
  if (root.attribute("type").value() != type) fail("", "not a VTKFile of type " + type);
  grid_ = root.child(type.c_str());
  if (!grid_) fail("", "has no element " + type);
  swapped_ = std::string_view(root.attribute("byte_order").value()) == "BigEndian";
  wide_headers_ = std::string_view(root.attribute("header_type").value()) == "UInt64";
  const std::string compressor = root.attribute("compressor").value();
  compressed_ = !compressor.empty();
  if (compressed_ && compressor != "vtkZLibDataCompressor")
    fail("", "compression " + compressor + " is not read");
  const std::string encoding = root.child("AppendedData").attribute("encoding").value();
  appended_base64_ = encoding == "base64";
  if (!encoding.empty() && encoding != "raw" && !appended_base64_) {
    fail("AppendedData", "encoding " + encoding + " is unknown");
  }
  if (appended_base64_ && data_ > 0) find_offsets();
}

namespace {

/// Whether values of this element stand in the text, as words or encoded.
bool begins_inline_array(std::string_view tag) {
  if (!tag.starts_with("<DataArray") || tag.ends_with("/>")) return false;
  const std::size_t format = tag.find(" format=");
  return format == std::string_view::npos || !tag.substr(format + 9).starts_with("appended");
}

/// Moves behind a tag, of which the cursor is at the begin. False where it has no end.
bool pass_tag(Cursor& in) {
  if (in.ahead(4) == "<!--") return in.find("-->") && (in.seek(in.position() + 3), true);
  for (char quote = 0;; in.seek(in.position() + 1)) {
    const std::string_view next = in.ahead(1);
    if (next.empty()) return false;
    if (quote != 0) {
      quote = next[0] == quote ? 0 : quote;
    } else if (next[0] == '"' || next[0] == '\'') {
      quote = next[0];
    } else if (next[0] == '>') {
      return in.seek(in.position() + 1), true;
    }
  }
}

}  // namespace

/// The file up to the appended data, without which it is read to its end. The values of an array in it are
/// left in the file: in their place it says where they are.
void VtkDocument::read_text() {
  Cursor in(file_);
  bool values_follow = false;
  for (std::uint64_t begin = 0;;) {
    const bool more = in.find("<");
    const std::uint64_t end = more ? in.position() : file_.size();
    if (values_follow) {
      text_ += std::to_string(begin) + " " + std::to_string(end);
    } else {
      copy_text(begin, end);
    }
    if (!more) return;
    const bool closed = pass_tag(in);
    begin = closed ? in.position() : file_.size();
    const std::size_t tag = text_.size();
    copy_text(end, begin);
    if (!closed) return;
    if (std::string_view(text_).substr(tag).starts_with("<AppendedData")) return begin_appended(in);
    values_follow = begins_inline_array(std::string_view(text_).substr(tag));
  }
}

void VtkDocument::copy_text(std::uint64_t begin, std::uint64_t end) {
  const std::size_t known = text_.size();
  text_.resize(known + (end - begin));
  file_.read_at(begin, text_.data() + known, end - begin);
}

/// The cursor is behind the tag, and has to find the mark.
void VtkDocument::begin_appended(Cursor& in) {
  if (!in.find("_")) fail("AppendedData", "the file is truncated: no data");
  data_ = in.position() + 1;
  text_ += "</AppendedData></VTKFile>";
}

void VtkDocument::fail(const std::string& entity, const std::string& reason) const {
  throw InputError(file_.name(), entity, reason);
}

std::uint64_t VtkDocument::count(pugi::xml_node node, const char* attribute) const {
  const std::string text = node.attribute(attribute).value();
  const auto value = parse_integer(text);
  if (!value || *value < 0 || *value > 0xFFFFFFFE) {
    fail(node.name(), std::string(attribute) + " is '" + text + "'");
  }
  return static_cast<std::uint64_t>(*value);
}

std::vector<double> VtkDocument::reals(pugi::xml_node array, std::uint64_t expected, Rows rows) const {
  return values<double>(array, expected, rows);
}

std::vector<std::int64_t> VtkDocument::integers(pugi::xml_node array, std::uint64_t expected,
                                                Rows rows) const {
  if (std::string_view(array.attribute("type").value()).starts_with("Float")) {
    fail(array_name(array), "has reals instead of integers");
  }
  return values<std::int64_t>(array, expected, rows);
}

std::uint64_t VtkDocument::size(pugi::xml_node array) const {
  std::uint64_t size = 0;
  if (is_text(array)) {
    const InlineSpan span = inline_span(array);
    Cursor in(file_, span.begin, span.end);
    TextPlace at{0, span.begin};
    pass_over(in, at, kAny);
    return at.value;
  }
  with_type(array.attribute("type").value(),
            [&](auto example) { size = bytes_of(array).size() / sizeof(example); });
  return size;
}

template <class T>
std::vector<T> VtkDocument::values(pugi::xml_node array, std::uint64_t expected, Rows rows) const {
  if (is_text(array)) return ascii_values<T>(array, expected, rows);
  std::vector<T> out;
  const bool known = with_type(array.attribute("type").value(), [&](auto example) {
    using Stored = decltype(example);
    VtkBytes& bytes = bytes_of(array);
    const std::uint64_t n = bytes.size() / sizeof(Stored);
    if (bytes.size() % sizeof(Stored) != 0 || (expected != kAny && n != expected)) {
      fail(array_name(array), "has " + std::to_string(bytes.size()) + " bytes instead of " +
                                  std::to_string(expected == kAny ? n + 1 : expected) + " values");
    }
    const std::uint64_t first = std::min(rows.first, n), count = std::min(rows.count, n - first);
    out.reserve(std::min(count, kMostReserved));
    std::vector<char> block(std::min(kReadAtOnce, count) * sizeof(Stored));
    for (std::uint64_t begin = 0; begin < count; begin += kReadAtOnce) {
      const std::uint64_t number = std::min(kReadAtOnce, count - begin);
      bytes.read((first + begin) * sizeof(Stored), number * sizeof(Stored), block.data());
      for (std::uint64_t i = 0; i < number; ++i)
        out.push_back(static_cast<T>(load<Stored>(block.data() + i * sizeof(Stored), swapped_)));
    }
  });
  if (!known)
    fail(array_name(array), "type '" + std::string(array.attribute("type").value()) + "' is unknown");
  return out;
}

VtkDocument::InlineSpan VtkDocument::inline_span(pugi::xml_node array) const {
  const std::string said = array.child_value();
  if (said.empty()) return {0, 0};  // an element without content
  Cursor in(file_.name(), said);
  in.enter(array_name(array));
  const std::uint64_t begin = in.text_count();
  return {begin, in.text_count()};
}

/// Moves the cursor of a text array to a value, or behind the last where there are fewer; `at`: where it is.
void VtkDocument::pass_over(Cursor& in, TextPlace& at, std::uint64_t value) const {
  const auto known = places_.find(at.position);
  if (known != places_.end() && known->second.value <= value) at = known->second;
  in.seek(at.position);
  for (in.skip_blanks(); at.value < value && !in.at_end(); in.skip_blanks()) in.word(), ++at.value;
  at.position = in.position();
}

template <class T>
std::vector<T> VtkDocument::ascii_values(pugi::xml_node array, std::uint64_t expected, Rows rows) const {
  const InlineSpan span = inline_span(array);
  Cursor in(file_, span.begin, span.end);
  TextPlace at{0, span.begin};
  if (expected != kAny) in.enter(array_name(array) + ", value"), in.require(expected, 1);
  pass_over(in, at, rows.first);
  in.enter(array_name(array) + ", value", at.value);
  std::vector<T> out;
  if (expected != kAny) out.reserve(std::min(rows.count, expected - std::min(expected, rows.first)));
  for (in.skip_blanks(); out.size() < rows.count && !in.at_end(); in.skip_blanks()) {
    in.next_row();
    if constexpr (std::is_same_v<T, double>) {
      out.push_back(in.text_real());
    } else {
      out.push_back(in.text_integer());
    }
  }
  places_[span.begin] = {at.value + out.size(), in.position()};
  const bool is_all = at.value + out.size() >= expected || in.at_end();
  if (expected == kAny || !is_all) return out;
  const std::uint64_t found = size(array);
  if (found == expected) return out;
  fail(array_name(array), "has " + std::to_string(found) + " values instead of " + std::to_string(expected));
}

std::uint64_t VtkDocument::appended_offset(pugi::xml_node array) const {
  const auto offset = parse_integer(array.attribute("offset").value());
  if (data_ == 0 || !offset || *offset < 0 || static_cast<std::uint64_t>(*offset) > file_.size() - data_)
    fail(array_name(array), "its offset is damaged, or the file is truncated");
  return static_cast<std::uint64_t>(*offset);
}

VtkStorage VtkDocument::storage_of(pugi::xml_node array) const {
  VtkStorage storage{.compressed = compressed_, .swapped = swapped_, .wide_headers = wide_headers_};
  const std::string_view format = array.attribute("format").value();
  if (format == "appended") {
    storage.begin = data_ + appended_offset(array);
    storage.base64 = appended_base64_;
    // Encoded arrays tell their end only together.
    const auto next = std::ranges::upper_bound(offsets_, storage.begin - data_);
    storage.end = storage.base64 && next != offsets_.end() ? data_ + *next : file_.size();
  } else if (format == "binary") {
    const InlineSpan span = inline_span(array);
    storage.begin = span.begin;
    storage.end = span.end;
    storage.base64 = true;
  } else {
    fail(array_name(array), "its format is unknown");
  }
  return storage;
}

VtkBytes& VtkDocument::bytes_of(pugi::xml_node array) const {
  const VtkStorage storage = storage_of(array);
  const auto known = bytes_.find(storage.begin);
  if (known != bytes_.end()) return known->second;
  return bytes_.emplace(storage.begin, VtkBytes(file_, array_name(array), storage)).first->second;
}

/// Of all appended arrays, as far as they lie in the file; ascending.
void VtkDocument::find_offsets() {
  for (const pugi::xpath_node found : xml_.select_nodes("//DataArray[@offset]")) {
    const auto offset = parse_integer(found.node().attribute("offset").value());
    if (offset && *offset >= 0 && static_cast<std::uint64_t>(*offset) <= file_.size() - data_)
      offsets_.push_back(static_cast<std::uint64_t>(*offset));
  }
  std::ranges::sort(offsets_);
}

// ---------------------------------------------------------------------------------------------------------
// Writing

namespace {

/// The underscore marks where the counting of offsets begins.
constexpr std::string_view kBeginAppended = "<AppendedData encoding=\"raw\">\n_";
constexpr std::string_view kEnd = "</VTKFile>\n";

std::string opening(const std::string& type, bool compress) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"" +
         (compress ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n";
}
std::string appended_at(std::uint64_t offset) {
  return " format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>";
}
constexpr std::string_view kBeginAscii = " format=\"ascii\">\n", kEndAscii = "\n</DataArray>\n";

template <class Out>
void write_text_values(Out& out, const std::string& type, std::span<const std::byte> values,
                       std::uint64_t offset) {
  with_type(type, [&](auto example) {
    using Stored = decltype(example);
    constexpr std::uint64_t kPerLine = 12;
    std::uint64_t number = offset / sizeof(Stored);
    TextOutput text(out, number % kPerLine == 0);
    for (std::size_t at = 0; at < values.size(); at += sizeof(Stored)) {
      const auto value = load<Stored>(reinterpret_cast<const char*>(values.data()) + at, false);
      // A byte would be written as a character.
      text.number(static_cast<std::conditional_t<sizeof(Stored) == 1, int, Stored>>(value));
      if (++number % kPerLine == 0) text.end_line();
    }
  });
}

}  // namespace

std::string VtkPlan::attributes(const std::string& type, const std::string& name, int num_components) {
  return "<DataArray type=\"" + type + "\" Name=\"" + VtkWriter::escaped(name) + "\" NumberOfComponents=\"" +
         std::to_string(num_components) + "\"";
}

void VtkPlan::add(const std::string& attributes, std::uint64_t bytes) {
  xml_.back() += attributes;
  xml_.emplace_back("\n");
  sizes_.push_back(bytes);
}

std::string VtkPlan::head(std::span<const std::uint64_t> lengths, bool compressed) const {
  std::string head = opening(type_, compressed);
  std::uint64_t offset = 0;
  for (std::size_t i = 0; i < lengths.size(); offset += lengths[i++]) head += xml_[i] + appended_at(offset);
  return head + xml_.back() + std::string(kBeginAppended);
}

std::string VtkPlan::head() const {
  std::vector<std::uint64_t> lengths = sizes_;
  for (std::uint64_t& length : lengths) length += sizeof(std::uint64_t);
  return head(lengths, false);
}

std::string VtkPlan::compressed_head(std::span<const std::uint64_t> lengths) const {
  return head(lengths, true);
}

std::uint64_t VtkPlan::position(std::size_t array) const {
  std::uint64_t position = head().size() + sizeof(std::uint64_t);
  for (std::size_t i = 0; i < array; ++i) position += sizes_[i] + sizeof(std::uint64_t);
  return position;
}

std::string VtkPlan::tail() { return "\n</AppendedData>\n" + std::string(kEnd); }

VtkTextHeads::VtkTextHeads(const std::string& type) : heads_{opening(type, false)} {}

void VtkTextHeads::array(const std::string& type, const std::string& name, int num_components,
                         int num_sections, const std::string& last) {
  heads_.back() += VtkPlan::attributes(type, name, num_components) + std::string(kBeginAscii);
  heads_.resize(heads_.size() + static_cast<std::size_t>(num_sections));
  heads_.back() = last + std::string(kEndAscii);
}

std::vector<std::string> VtkTextHeads::finish() {
  heads_.back() += kEnd;
  return std::move(heads_);
}

std::string vtk_text(const std::string& type, std::span<const std::byte> values, std::uint64_t offset) {
  TextInMemory text;
  write_text_values(text, type, values, offset);
  return std::move(text.text);
}

VtkWriter::VtkWriter(const std::filesystem::path& path, const std::string& type, const WriteOptions& options)
    : file_(path),
      type_(type),
      ascii_(options.encoding == WriteOptions::Encoding::ascii),
      compress_(options.compress && !ascii_) {}

std::string VtkWriter::escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

void VtkWriter::text(const std::string& line) { items_.push_back({line, {}, 0, {}}); }

void VtkWriter::array(const std::string& type, const std::string& name, int num_components,
                      std::uint64_t bytes, std::function<std::vector<char>()> make) {
  items_.push_back({VtkPlan::attributes(type, name, num_components), type, bytes, std::move(make)});
}

void VtkWriter::finish() {
  if (ascii_) {
    write_ascii();
  } else {
    compress_ ? write_compressed() : write_appended();
  }
  file_.commit();
}

void VtkWriter::write_ascii() {
  file_.write(opening(type_, false));
  for (const Item& item : items_) {
    file_.write(item.xml);
    if (!item.make) {
      file_.write("\n");
      continue;
    }
    file_.write(kBeginAscii);
    const std::vector<char> data = item.make();
    write_text_values(file_, item.type, std::as_bytes(std::span(data)), 0);
    file_.write(kEndAscii);
  }
  file_.write(kEnd);
}

VtkPlan VtkWriter::plan() const {
  VtkPlan plan(type_);
  for (const Item& item : items_) item.make ? plan.add(item.xml, item.bytes) : plan.text(item.xml);
  return plan;
}

void VtkWriter::write_appended() {
  file_.write(plan().head());
  for (const Item& item : items_) {
    if (!item.make) continue;
    file_.write_value(item.bytes);
    const std::vector<char> data = item.make();
    file_.write(data.data(), data.size());
  }
  file_.write(VtkPlan::tail());
}

/// The sizes of compressed arrays are needed first.
void VtkWriter::write_compressed() {
  std::vector<std::vector<char>> arrays;
  std::vector<std::uint64_t> lengths;
  for (const Item& item : items_) {
    if (!item.make) continue;
    arrays.push_back(vtk_compressed(item.make()));
    lengths.push_back(arrays.back().size());
  }
  file_.write(plan().compressed_head(lengths));
  for (const std::vector<char>& array : arrays) file_.write(array.data(), array.size());
  file_.write(VtkPlan::tail());
}

}  // namespace weft::meshing
