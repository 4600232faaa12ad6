// VTK's XML files: the document, and the arrays in it as text, base64 or raw bytes, also compressed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <pugixml.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/vtk/vtk_bytes.h"

namespace weft::meshing {

/// A file's text, parsed, and the arrays behind it, which are read when they are asked for. Everything that
/// is not as expected throws InputError(file, array, reason).
class VtkDocument {
 public:
  /// `type` is what VTKFile must declare, such as UnstructuredGrid.
  VtkDocument(const std::filesystem::path& path, const std::string& type);

  const std::string& name() const { return file_.name(); }
  /// The element below VTKFile that is called like the type.
  pugi::xml_node grid() const { return grid_; }
  [[noreturn]] void fail(const std::string& entity, const std::string& reason) const;
  /// An attribute that is a count.
  std::uint64_t count(pugi::xml_node node, const char* attribute) const;

  /// The values of a DataArray; fails unless there are `expected` of them (kAny: however many).
  static constexpr std::uint64_t kAny = ~std::uint64_t{0};
  std::vector<double> reals(pugi::xml_node array, std::uint64_t expected = kAny) const {
    return reals(array, expected, {});
  }
  std::vector<std::int64_t> integers(pugi::xml_node array, std::uint64_t expected = kAny) const {
    return integers(array, expected, {});
  }

  /// `count` of the values from `first` on; all there are by default.
  struct Rows {
    std::uint64_t first = 0, count = kAny;
  };
  /// Part of the values of an array. Rows of text are found by passing over those before them, from the last
  /// ones that have been read on; of others see VtkBytes.
  std::vector<double> reals(pugi::xml_node array, std::uint64_t expected, Rows rows) const;
  std::vector<std::int64_t> integers(pugi::xml_node array, std::uint64_t expected, Rows rows) const;
  /// How many values an array has.
  std::uint64_t size(pugi::xml_node array) const;

 private:
  /// Where the values of an array in the text are in the file.
  struct InlineSpan {
    std::uint64_t begin, end;
  };
  /// A value of a text array, by its number, and where it is.
  struct TextPlace {
    std::uint64_t value, position;
  };

  void read_text();
  void copy_text(std::uint64_t begin, std::uint64_t end);
  void begin_appended(Cursor& in);
  void find_offsets();
  InlineSpan inline_span(pugi::xml_node array) const;
  void pass_over(Cursor& in, TextPlace& at, std::uint64_t value) const;
  template <class T>
  std::vector<T> values(pugi::xml_node array, std::uint64_t expected, Rows rows) const;
  template <class T>
  std::vector<T> ascii_values(pugi::xml_node array, std::uint64_t expected, Rows rows) const;
  VtkStorage storage_of(pugi::xml_node array) const;
  VtkBytes& bytes_of(pugi::xml_node array) const;
  std::uint64_t appended_offset(pugi::xml_node array) const;

  InputFile file_;
  std::string text_;  ///< up to the appended data, without the values of arrays in it
  pugi::xml_document xml_;
  pugi::xml_node grid_;
  bool swapped_ = false, wide_headers_ = false, compressed_ = false;
  bool appended_base64_ = false;
  std::uint64_t data_ = 0;              ///< where the appended data begin
  std::vector<std::uint64_t> offsets_;  ///< of appended arrays that are encoded
  // By the begin of an array: behind what has been read of one of text, and how others are read.
  mutable std::map<std::uint64_t, TextPlace> places_;
  mutable std::map<std::uint64_t, VtkBytes> bytes_;
};

/// What stands around the appended arrays of a document, and where these lie.
class VtkPlan {
 public:
  explicit VtkPlan(std::string type) : type_(std::move(type)) {}

  /// Lines of XML between the arrays.
  void text(const std::string& line) { xml_.back() += line + "\n"; }
  void array(const std::string& type, const std::string& name, int num_components, std::uint64_t bytes) {
    add(attributes(type, name, num_components), bytes);
  }
  /// The file up to its data, which are not compressed.
  std::string head() const;
  /// The same where they are; `lengths` of the arrays are those of all their blocks, and the header.
  std::string compressed_head(std::span<const std::uint64_t> lengths) const;
  std::uint64_t num_arrays() const { return sizes_.size(); }
  /// Of an array, not compressed.
  std::uint64_t bytes(std::size_t array) const { return sizes_[array]; }
  /// Where the first of these is; the 8 in front hold their number.
  std::uint64_t position(std::size_t array) const;
  /// What follows the data.
  static std::string tail();

  static std::string attributes(const std::string& type, const std::string& name, int num_components);

 private:
  friend class VtkWriter;
  void add(const std::string& attributes, std::uint64_t bytes);
  std::string head(std::span<const std::uint64_t> lengths, bool compressed) const;

  std::string type_;
  std::vector<std::string> xml_{{}};  ///< up to each array's place, and behind the last
  std::vector<std::uint64_t> sizes_;
};

/// What stands around the values of a document whose arrays are text: a head in front of each section of
/// values, and one behind the last.
class VtkTextHeads {
 public:
  explicit VtkTextHeads(const std::string& type);

  void text(const std::string& line) { heads_.back() += line + "\n"; }
  /// The values of an array, in so many sections, and `last` ones as text.
  void array(const std::string& type, const std::string& name, int num_components, int num_sections,
             const std::string& last);
  std::vector<std::string> finish();

 private:
  std::vector<std::string> heads_;
};

/// Values of an array as text; the first of them is at byte `offset` of the array.
std::string vtk_text(const std::string& type, std::span<const std::byte> values, std::uint64_t offset);

/// Writes a document whose arrays come in the order in which they are described.
class VtkWriter {
 public:
  VtkWriter(const std::filesystem::path& path, const std::string& type, const WriteOptions& options);

  /// Lines of XML between the arrays.
  void text(const std::string& line);
  /// An array of `bytes` bytes, which `make` gives when they are needed.
  void array(const std::string& type, const std::string& name, int num_components, std::uint64_t bytes,
             std::function<std::vector<char>()> make);
  /// Writes everything, whole or not at all.
  void finish();

  static std::string escaped(std::string_view text);

 private:
  struct Item {
    std::string xml;  ///< text, or the attributes of an array
    std::string type;
    std::uint64_t bytes = 0;
    std::function<std::vector<char>()> make;  ///< none: text
  };

  VtkPlan plan() const;
  void write_ascii();
  void write_appended();
  void write_compressed();

  AtomicFile file_;
  std::string type_;
  bool ascii_, compress_;
  std::vector<Item> items_;
};

}  // namespace weft::meshing
