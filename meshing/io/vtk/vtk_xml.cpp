// pugixml reads the text; what is appended is no XML and is read by position. zlib does the compression.
#include "meshing/io/vtk/vtk_xml.h"

#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/files/byte_order.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/text_output.h"

namespace weft::meshing {
namespace {

constexpr std::uint64_t kReadAtOnce = std::uint64_t{1} << 16;  ///< values of raw arrays
constexpr std::uint64_t kBlockSize = std::uint64_t{1} << 18;   ///< of compressed data that we write

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

constexpr std::array<std::int8_t, 256> base64_digits() {
  std::array<std::int8_t, 256> digits{};
  for (auto& digit : digits) digit = -1;
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kAlphabet.size(); ++i) {
    digits[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::int8_t>(i);
  }
  return digits;
}
constexpr std::array<std::int8_t, 256> kDigits = base64_digits();

/// The bytes that follow one another in encoded data. Headers are encoded by themselves, with padding behind
/// them, or together with the data, depending on who wrote the file: padding just ends a group.
class Source {
 public:
  Source(std::string_view text, bool base64) : text_(text), base64_(base64) {}

  /// The next `size` bytes; nothing where the data end before.
  std::optional<std::string_view> take(std::uint64_t size) {
    if (base64_) return take_base64(size);
    if (size > text_.size() - at_) return std::nullopt;
    const std::string_view taken = text_.substr(at_, size);
    at_ += size;
    return taken;
  }

 private:
  std::optional<std::string_view> take_base64(std::uint64_t size) {
    decoded_.erase(0, std::exchange(used_, 0));
    if (size > text_.size()) return std::nullopt;  // encoded bytes are more than decoded ones
    decoded_.reserve(size + 3);
    while (decoded_.size() < size) {
      if (!decode_group()) return std::nullopt;
    }
    used_ = size;
    return std::string_view(decoded_).substr(0, size);
  }

  bool decode_group() {
    std::uint32_t bits = 0;
    int digits = 0, padding = 0;
    while (digits + padding < 4) {
      if (at_ == text_.size()) return false;
      const char c = text_[at_++];
      if (is_space(c)) continue;
      const std::int8_t digit = kDigits[static_cast<unsigned char>(c)];
      if (digit < 0 && c != '=') return false;
      padding += digit < 0;
      digits += digit >= 0;
      bits = bits << 6 | static_cast<std::uint32_t>(digit < 0 ? 0 : digit);
    }
    if (digits < 2) return false;
    for (int byte = 0; byte < digits - 1; ++byte) {
      decoded_.push_back(static_cast<char>(bits >> (16 - 8 * byte) & 0xFF));
    }
    return true;
  }

  std::string_view text_;
  bool base64_;
  std::size_t at_ = 0;
  std::string decoded_;
  std::uint64_t used_ = 0;
};

std::string array_name(pugi::xml_node array) {
  const std::string name = array.attribute("Name").value();
  return name.empty() ? "a DataArray" : "array " + name;
}

/// Whether its values are words.
bool is_text(pugi::xml_node array) {
  const std::string_view format = array.attribute("format").value();
  return format == "ascii" || format.empty();
}

/// The data of one array in blocks, as VTK stores them.
std::vector<char> compressed(const std::vector<char>& data) {
  const std::uint64_t num_blocks = (data.size() + kBlockSize - 1) / kBlockSize;
  std::vector<std::vector<Bytef>> blocks(num_blocks);
  tbb::parallel_for(std::uint64_t{0}, num_blocks, [&](std::uint64_t i) {
    const std::uint64_t begin = i * kBlockSize, size = std::min(kBlockSize, data.size() - begin);
    uLongf length = compressBound(size);
    blocks[i].resize(length);
    // Cannot fail with this bound but for memory, of which resize() would have spoken.
    compress2(blocks[i].data(), &length, reinterpret_cast<const Bytef*>(data.data() + begin), size,
              Z_BEST_SPEED);
    blocks[i].resize(length);
  });
  std::vector<std::uint64_t> header = {num_blocks, kBlockSize, data.size() % kBlockSize};
  for (const auto& block : blocks) header.push_back(block.size());
  std::vector<char> out(header.size() * sizeof(std::uint64_t));
  std::memcpy(out.data(), header.data(), out.size());
  for (const auto& block : blocks) out.insert(out.end(), block.begin(), block.end());
  return out;
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
}

namespace {

/// Whether values of this element stand in the text as words.
bool begins_text_array(std::string_view tag) {
  if (!tag.starts_with("<DataArray") || tag.ends_with("/>")) return false;
  const std::size_t format = tag.find(" format=");
  return format == std::string_view::npos || tag.substr(format + 9).starts_with("ascii");
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

/// The file up to the appended data, without which it is read to its end. The values of a text array are left
/// in the file: in their place it says where they are.
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
    values_follow = begins_text_array(std::string_view(text_).substr(tag));
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

bool VtkDocument::has_rows(pugi::xml_node array) const {
  if (is_text(array)) return true;
  return !compressed_ && !appended_base64_ && data_ > 0 &&
         std::string_view(array.attribute("format").value()) == "appended";
}

std::uint64_t VtkDocument::size(pugi::xml_node array) const {
  std::uint64_t size = 0;
  if (is_text(array)) {
    const TextSpan span = text_span(array);
    Cursor in(file_, span.begin, span.end);
    TextPlace at{0, span.begin};
    pass_over(in, at, kAny);
    return at.value;
  }
  with_type(array.attribute("type").value(),
            [&](auto example) { size = span_of(array).bytes / sizeof(example); });
  return size;
}

template <class T>
std::vector<T> VtkDocument::values(pugi::xml_node array, std::uint64_t expected, Rows rows) const {
  if (is_text(array)) return ascii_values<T>(array, expected, rows);
  std::vector<T> out;
  const bool known = with_type(array.attribute("type").value(), [&](auto example) {
    using Stored = decltype(example);
    const bool raw = has_rows(array);
    const std::string all = raw ? std::string() : decoded(array);
    const Span span = raw ? span_of(array) : Span{0, all.size()};
    const std::uint64_t n = span.bytes / sizeof(Stored);
    if (span.bytes % sizeof(Stored) != 0 || (expected != kAny && n != expected)) {
      fail(array_name(array), "has " + std::to_string(span.bytes) + " bytes instead of " +
                                  std::to_string(expected == kAny ? n + 1 : expected) + " values");
    }
    const std::uint64_t first = std::min(rows.first, n), count = std::min(rows.count, n - first);
    out.resize(count);
    const auto convert = [&](const char* bytes, std::uint64_t begin, std::uint64_t number) {
      for (std::uint64_t i = 0; i < number; ++i)
        out[begin + i] = static_cast<T>(load<Stored>(bytes + i * sizeof(Stored), swapped_));
    };
    if (!raw) return convert(all.data() + first * sizeof(Stored), 0, count);
    std::vector<char> block(std::min(kReadAtOnce, count) * sizeof(Stored));
    for (std::uint64_t begin = 0; begin < count; begin += kReadAtOnce) {
      const std::uint64_t number = std::min(kReadAtOnce, count - begin);
      file_.read_at(span.position + (first + begin) * sizeof(Stored), block.data(), number * sizeof(Stored));
      convert(block.data(), begin, number);
    }
  });
  if (!known)
    fail(array_name(array), "type '" + std::string(array.attribute("type").value()) + "' is unknown");
  return out;
}

VtkDocument::TextSpan VtkDocument::text_span(pugi::xml_node array) const {
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
  const TextSpan span = text_span(array);
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

VtkDocument::Span VtkDocument::span_of(pugi::xml_node array) const {
  const std::uint64_t begin = data_ + appended_offset(array), header = wide_headers_ ? 8 : 4;
  std::array<char, 8> bytes{};
  std::uint64_t size = file_.size();
  if (header <= file_.size() - begin) {
    file_.read_at(begin, bytes.data(), header);
    size = wide_headers_ ? load<std::uint64_t>(bytes.data(), swapped_)
                         : load<std::uint32_t>(bytes.data(), swapped_);
  }
  if (header > file_.size() - begin || size > file_.size() - begin - header)
    fail(array_name(array), "the file is truncated, or its data are damaged");
  return {begin + header, size};
}

std::string_view VtkDocument::appended() const {
  if (appended_.empty() && file_.size() > data_) {
    appended_.resize(file_.size() - data_);
    file_.read_at(data_, appended_.data(), appended_.size());
  }
  return appended_;
}

/// The bytes of an array that is encoded, or stands in the text.
std::string VtkDocument::decoded(pugi::xml_node array) const {
  const std::string entity = array_name(array);
  std::string_view text = array.child_value();
  bool base64 = true;
  if (std::string_view(array.attribute("format").value()) == "appended") {
    text = appended().substr(appended_offset(array));
    base64 = appended_base64_;
  } else if (std::string_view(array.attribute("format").value()) != "binary") {
    fail(entity, "its format is unknown");
  }
  Source source(text, base64);
  const auto take = [&](std::uint64_t size) {
    const auto taken = source.take(size);
    if (!taken) fail(entity, "the file is truncated, or its data are damaged");
    return *taken;
  };
  const auto header = [&]() -> std::uint64_t {
    return wide_headers_ ? load<std::uint64_t>(take(8).data(), swapped_)
                         : load<std::uint32_t>(take(4).data(), swapped_);
  };
  if (!compressed_) return std::string(take(header()));
  const std::uint64_t num_blocks = header(), block_size = header(), last_size = header();
  if (num_blocks > text.size()) fail(entity, "the number of its compressed blocks is damaged");
  std::vector<std::uint64_t> sizes(num_blocks);
  for (std::uint64_t& size : sizes) size = header();
  std::string out;
  for (std::uint64_t i = 0; i < num_blocks; ++i) {
    const std::string_view block = take(sizes[i]);
    const std::uint64_t full = i + 1 == num_blocks && last_size > 0 ? last_size : block_size;
    // Deflate makes nothing smaller than by a factor of 1032: a damaged size must not make us allocate.
    if (full / 1032 > block.size() + 16) fail(entity, "the size of a compressed block is damaged");
    const std::size_t begin = out.size();
    out.resize(begin + full);
    uLongf length = full;
    const int result = uncompress(reinterpret_cast<Bytef*>(out.data() + begin), &length,
                                  reinterpret_cast<const Bytef*>(block.data()), block.size());
    if (result != Z_OK || length != full) fail(entity, "its compressed data are damaged");
  }
  return out;
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

}  // namespace

std::string VtkPlan::attributes(const std::string& type, const std::string& name, int num_components) {
  return "<DataArray type=\"" + type + "\" Name=\"" + VtkWriter::escaped(name) + "\" NumberOfComponents=\"" +
         std::to_string(num_components) + "\"";
}

void VtkPlan::array(const std::string& type, const std::string& name, int num_components,
                    std::uint64_t bytes) {
  add(attributes(type, name, num_components), bytes);
}

void VtkPlan::add(const std::string& attributes, std::uint64_t bytes) {
  text(attributes + appended_at(offset_));
  sizes_.push_back(bytes);
  offset_ += sizeof(std::uint64_t) + bytes;
}

std::string VtkPlan::head() const { return opening(type_, false) + xml_ + std::string(kBeginAppended); }

std::uint64_t VtkPlan::position(std::size_t array) const {
  std::uint64_t position = head().size() + sizeof(std::uint64_t);
  for (std::size_t i = 0; i < array; ++i) position += sizes_[i] + sizeof(std::uint64_t);
  return position;
}

std::string VtkPlan::tail() { return "\n</AppendedData>\n" + std::string(kEnd); }

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
  TextOutput text(file_);
  for (const Item& item : items_) {
    if (!item.make) {
      text.line(item.xml);
      continue;
    }
    text.line(item.xml + " format=\"ascii\">");
    const std::vector<char> data = item.make();
    with_type(item.type, [&](auto example) {
      using Stored = decltype(example);
      constexpr std::size_t kPerLine = 12;
      for (std::size_t i = 0; i * sizeof(Stored) < data.size(); ++i) {
        const auto value = load<Stored>(data.data() + i * sizeof(Stored), false);
        // A byte would be written as a character.
        text.number(static_cast<std::conditional_t<sizeof(Stored) == 1, int, Stored>>(value));
        if (i % kPerLine == kPerLine - 1) text.end_line();
      }
    });
    text.end_line();
    text.line("</DataArray>");
  }
  file_.write(kEnd);
}

void VtkWriter::write_appended() {
  VtkPlan plan(type_);
  for (const Item& item : items_) item.make ? plan.add(item.xml, item.bytes) : plan.text(item.xml);
  file_.write(plan.head());
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
  std::vector<std::vector<char>> blocks;
  std::uint64_t offset = 0;
  file_.write(opening(type_, true));
  for (const Item& item : items_) {
    file_.write(item.xml);
    if (item.make) {
      file_.write(appended_at(offset));
      blocks.push_back(compressed(item.make()));
      offset += blocks.back().size();
    }
    file_.write("\n");
  }
  file_.write(kBeginAppended);
  for (const std::vector<char>& block : blocks) file_.write(block.data(), block.size());
  file_.write(VtkPlan::tail());
}

}  // namespace weft::meshing
