// VTK's XML files: the document, and the arrays in it as text, base64 or raw bytes, also compressed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/mesh_contents.h"

namespace weft::meshing {

/// A parsed file. Everything that is not as expected throws InputError(file, array, reason).
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
  std::vector<double> reals(pugi::xml_node array, std::uint64_t expected = kAny) const;
  std::vector<std::int64_t> integers(pugi::xml_node array, std::uint64_t expected = kAny) const;

 private:
  struct Bytes;
  template <class T>
  std::vector<T> values(pugi::xml_node array, std::uint64_t expected) const;
  template <class T>
  std::vector<T> ascii_values(pugi::xml_node array, std::uint64_t expected) const;
  Bytes decoded(pugi::xml_node array) const;

  FileBytes file_;
  pugi::xml_document xml_;
  pugi::xml_node grid_;
  bool swapped_ = false, wide_headers_ = false, compressed_ = false;
  bool appended_base64_ = false;
  std::string_view appended_;
};

/// What stands around the appended, uncompressed arrays of a document, and where these lie.
class VtkPlan {
 public:
  explicit VtkPlan(std::string type) : type_(std::move(type)) {}

  /// Lines of XML between the arrays.
  void text(const std::string& line) { xml_ += line + "\n"; }
  void array(const std::string& type, const std::string& name, int num_components, std::uint64_t bytes);
  /// The file up to its data.
  std::string head() const;
  /// Bytes of an array, and the position of the first of them; the 8 in front hold their number.
  std::uint64_t num_arrays() const { return sizes_.size(); }
  std::uint64_t bytes(std::size_t array) const { return sizes_[array]; }
  std::uint64_t position(std::size_t array) const;
  /// What follows the data.
  static std::string tail();

  static std::string attributes(const std::string& type, const std::string& name, int num_components);

 private:
  friend class VtkWriter;
  void add(const std::string& attributes, std::uint64_t bytes);

  std::string type_, xml_;
  std::vector<std::uint64_t> sizes_;
  std::uint64_t offset_ = 0;
};

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

  void write_ascii();
  void write_appended();
  void write_compressed();

  AtomicFile file_;
  std::string type_;
  bool ascii_, compress_;
  std::vector<Item> items_;
};

}  // namespace weft::meshing
