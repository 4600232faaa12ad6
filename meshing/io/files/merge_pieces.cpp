// Numbers the points of the pieces anew, and moves everything that refers to them.
#include "meshing/io/files/merge_pieces.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>

#include "meshing/io/files/point_merger.h"
#include "meshing/mesh/renumber_vertices.h"

namespace weft::meshing {
namespace {

class Merger {
 public:
  explicit Merger(bool by_ids) : by_ids_(by_ids), places_(merged_.mesh.points) {}

  void add(MeshPiece& piece) {
    MeshData& from = piece.contents.mesh;
    MeshData& to = merged_.mesh;
    find_points(piece);
    add_elements(from.tets, from.tet_refs, to.tets, to.tet_refs);
    add_elements(from.triangles, from.triangle_refs, to.triangles, to.triangle_refs);
    add_elements(from.edges, from.edge_refs, to.edges, to.edge_refs);
    for (const std::uint32_t corner : from.corners) to.corners.push_back(numbers_[corner]);
    to.point_refs.resize(to.points.size());
    for (std::size_t i = 0; i < numbers_.size(); ++i) to.point_refs[numbers_[i]] = from.point_refs[i];
    add_fields(piece.contents.fields);
    for (const Dropped& d : piece.contents.dropped) merged_.drop(d.what, d.count);
    merged_.foreign_volumes += piece.contents.foreign_volumes;
    ++num_pieces_;
  }

  MeshContents finish() {
    std::vector<std::uint32_t>& corners = merged_.mesh.corners;
    std::ranges::sort(corners);
    corners.erase(std::ranges::unique(corners).begin(), corners.end());
    std::erase_if(fields_, [this](const Counted& field) {
      if (field.pieces == num_pieces_) return false;
      merged_.drop("fields that some pieces lack");
      return true;
    });
    for (Counted& counted : fields_) {
      counted.field.values.resize(merged_.mesh.points.size() *
                                  static_cast<std::size_t>(components(counted.field.kind)));
      merged_.fields.fields.push_back(std::move(counted.field));
    }
    merged_.complete();
    order_by_ids();
    return std::move(merged_);
  }

 private:
  struct Counted {
    Field field;
    std::size_t pieces = 0;  ///< that have it
  };

  void find_points(const MeshPiece& piece) {
    const std::vector<Point>& points = piece.contents.mesh.points;
    numbers_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!by_ids_) {
        numbers_[i] = places_.index(points[i]);
        continue;
      }
      const auto next = static_cast<std::uint32_t>(merged_.mesh.points.size());
      const auto [known, is_new] = ids_.try_emplace(piece.global_ids[i], next);
      if (is_new) merged_.mesh.points.push_back(points[i]);
      numbers_[i] = known->second;
    }
  }

  /// IDs that are 0, 1, 2, ... say the order of the points before the mesh was cut.
  void order_by_ids() {
    const std::size_t n = merged_.mesh.points.size();
    if (!by_ids_) return;
    std::vector<std::uint32_t> order(n), numbers(n);
    for (const auto& [id, number] : ids_) {
      if (id < 0 || static_cast<std::uint64_t>(id) >= n) return;
      order[static_cast<std::size_t>(id)] = number;
      numbers[number] = static_cast<std::uint32_t>(id);
    }
    MeshData& mesh = merged_.mesh;
    reorder(order, 1, mesh.points);
    reorder(order, 1, mesh.point_refs);
    for (Field& field : merged_.fields.fields) {
      reorder(order, static_cast<std::size_t>(components(field.kind)), field.values);
    }
    renumber_vertices(mesh.tets, numbers);
    renumber_vertices(mesh.triangles, numbers);
    renumber_vertices(mesh.edges, numbers);
    for (std::uint32_t& corner : mesh.corners) corner = numbers[corner];
    std::ranges::sort(mesh.corners);
  }

  template <class Row>
  static void reorder(const std::vector<std::uint32_t>& order, std::size_t length, std::vector<Row>& rows) {
    std::vector<Row> old(rows.size());
    old.swap(rows);
    for (std::size_t i = 0; i < order.size(); ++i)
      std::copy_n(&old[order[i] * length], length, &rows[i * length]);
  }

  template <class Elements>
  void add_elements(const Elements& from, const std::vector<std::int32_t>& from_refs, Elements& to,
                    std::vector<std::int32_t>& to_refs) {
    for (auto element : from) {
      for (std::uint32_t& v : element) v = numbers_[v];
      to.push_back(element);
    }
    to_refs.insert(to_refs.end(), from_refs.begin(), from_refs.end());
  }

  void add_fields(const SolutionData& from) {
    for (const Field& field : from.fields) {
      auto known = std::ranges::find_if(fields_, [&](const Counted& c) {
        return c.field.name == field.name && c.field.kind == field.kind && c.pieces == num_pieces_;
      });
      if (known == fields_.end()) {
        fields_.push_back({{field.kind, {}, field.name}, num_pieces_ == 0 ? std::size_t{0} : kNever});
        known = fields_.end() - 1;
      }
      const auto length = static_cast<std::size_t>(components(field.kind));
      known->field.values.resize(merged_.mesh.points.size() * length);
      for (std::size_t i = 0; i < numbers_.size(); ++i) {
        std::copy_n(field.values.data() + i * length, length,
                    known->field.values.data() + numbers_[i] * length);
      }
      if (known->pieces != kNever) ++known->pieces;
    }
  }

  static constexpr std::size_t kNever = ~std::size_t{0};  ///< lacked by an earlier piece

  bool by_ids_;
  MeshContents merged_;
  PointMerger places_;
  std::unordered_map<std::int64_t, std::uint32_t> ids_;
  std::vector<std::uint32_t> numbers_;  ///< of the points of the piece being added
  std::vector<Counted> fields_;
  std::size_t num_pieces_ = 0;
};

}  // namespace

MeshContents merge_pieces(std::vector<MeshPiece> pieces) {
  if (pieces.size() == 1) return std::move(pieces[0].contents);
  const bool by_ids = std::ranges::all_of(pieces, [](const MeshPiece& piece) {
    return piece.global_ids.size() == piece.contents.mesh.points.size();
  });
  Merger merger(by_ids);
  for (MeshPiece& piece : pieces) {
    merger.add(piece);
    piece = {};
  }
  return merger.finish();
}

}  // namespace weft::meshing
