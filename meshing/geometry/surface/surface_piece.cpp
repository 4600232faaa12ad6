// A piece as a block of bytes, and sets of pieces.
#include "meshing/geometry/surface/surface_piece.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace weft::meshing {

namespace {

constexpr std::size_t kLists = 10;

/// At the beginning of a piece's bytes; the lists follow in the order of for_each_list().
struct Head {
  std::uint32_t id;
  std::array<std::uint32_t, kLists> sizes;
  std::uint32_t unused;  ///< 0: no byte is undefined
  Box box;
};

/// So that lists of doubles lie as these must.
constexpr std::size_t rounded_up(std::size_t bytes) { return (bytes + 7) / 8 * 8; }

template <class Piece, class F>
void for_each_list(Piece& p, const F& f) {
  f(p.points), f(p.handles), f(p.normals), f(p.parameters), f(p.features);
  f(p.triangles), f(p.corners), f(p.vertices), f(p.triangle_list), f(p.feature_list);
}

Head head_of(const SurfacePieceParts& parts) {
  Head head{parts.id, {}, 0, {}};
  std::size_t i = 0;
  for_each_list(parts, [&](const auto& list) { head.sizes[i++] = static_cast<std::uint32_t>(list.size()); });
  for (const Point& p : parts.points) head.box.include(p);
  for (const SurfaceFeature& f : parts.features)
    for (const Point& p : f.ends) head.box.include(p);
  return head;
}

}  // namespace

SurfacePiece::SurfacePiece(const SurfacePieceParts& parts) {
  const Head head = head_of(parts);
  std::size_t size = rounded_up(sizeof head);
  for_each_list(parts, [&](const auto& list) { size += rounded_up(list.size() * sizeof(list[0])); });
  const auto words = std::make_shared<std::vector<std::uint64_t>>(size / 8);
  auto* at = reinterpret_cast<std::byte*>(words->data());
  const auto put = [&](const void* data, std::size_t bytes) {
    if (bytes > 0) std::memcpy(at, data, bytes);
    at += rounded_up(bytes);
  };
  put(&head, sizeof head);
  for_each_list(parts, [&](const auto& list) { put(list.data(), list.size() * sizeof(list[0])); });
  bytes_ = std::as_bytes(std::span(*words));
  owner_ = words;
  find_parts();
}

SurfacePiece::SurfacePiece(std::span<const std::byte> bytes, std::shared_ptr<const void> owner)
    : bytes_(bytes), owner_(std::move(owner)) {
  find_parts();
}

void SurfacePiece::find_parts() {
  Head head{};
  std::size_t next = rounded_up(sizeof head), i = 0;
  const auto require = [&](bool holds) {
    if (!holds) throw std::runtime_error("a piece of the surface does not have the size that it says");
  };
  require(bytes_.size() >= next);
  std::memcpy(&head, bytes_.data(), sizeof head);
  id = head.id;
  box = head.box;
  for_each_list(*this, [&]<class T>(std::span<const T>& list) {
    const std::size_t count = head.sizes[i++], bytes = rounded_up(count * sizeof(T));
    require(bytes <= bytes_.size() - next);
    list = {reinterpret_cast<const T*>(bytes_.data() + next), count};
    next += bytes;
  });
  require(next == bytes_.size());
}

void SurfacePieces::add(std::span<const Piece> pieces) {
  for (const Piece& piece : pieces) {
    const std::uint32_t row = piece->id >> kRowBits;
    if (row >= row_of_.size()) row_of_.resize(row + 1, kNoName);
    if (row_of_[row] == kNoName) {
      row_of_[row] = static_cast<std::uint32_t>(rows_.size());
      rows_.push_back({});
    }
    const SurfacePiece*& place = rows_[row_of_[row]][piece->id & kRowMask];
    if (place) continue;
    place = piece.get();
    pieces_.push_back(piece);
  }
  std::ranges::sort(pieces_, {}, [](const Piece& piece) { return piece->id; });
}

}  // namespace weft::meshing
