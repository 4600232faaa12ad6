// Tables as bytes: arrays one after the other, each behind its length.
#include "meshing/geometry/surface/surface_tables.h"

#include <cstring>
#include <type_traits>
#include <utility>

namespace weft::meshing {
namespace {

class Writer {
 public:
  template <class T>
  void operator()(const std::vector<T>& values) {
    const std::uint64_t size = values.size();
    put(&size, sizeof size);
    if constexpr (std::is_trivially_copyable_v<T>)
      put(values.data(), size * sizeof(T));
    else
      for (const T& value : values) (*this)(value);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void put(const void* data, std::size_t bytes) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + bytes);
  }
  std::vector<std::byte> bytes_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  void operator()(std::vector<T>& values) {
    std::uint64_t size = 0;
    get(&size, sizeof size);
    values.resize(size);
    if constexpr (std::is_trivially_copyable_v<T>)
      get(values.data(), size * sizeof(T));
    else
      for (T& value : values) (*this)(value);
  }

 private:
  void get(void* data, std::size_t bytes) {
    if (bytes > 0) std::memcpy(data, bytes_.data(), bytes);
    bytes_ = bytes_.subspan(bytes);
  }
  std::span<const std::byte> bytes_;
};

template <class Tables, class Archive>
void for_each_table(Tables& tables, Archive& archive) {
  archive(tables.patches), archive(tables.planes), archive(tables.curves), archive(tables.lines);
  archive(tables.curve_in_pieces), archive(tables.patch_faces);
  archive(tables.curve_edge), archive(tables.curve_patch);
}

}  // namespace

std::vector<std::byte> bytes_of(const SurfaceTables& tables) {
  Writer writer;
  for_each_table(tables, writer);
  return writer.take();
}

std::shared_ptr<const SurfaceTables> tables_of(std::span<const std::byte> bytes,
                                               std::shared_ptr<const Model> model) {
  auto tables = std::make_shared<SurfaceTables>();
  tables->model = std::move(model);
  Reader reader(bytes);
  for_each_table(*tables, reader);
  return tables;
}

}  // namespace weft::meshing
