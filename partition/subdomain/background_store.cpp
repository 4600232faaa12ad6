// Cutting, naming and joining of background pieces.
#include "partition/subdomain/background_store.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "meshing/mesh/tet_tables.h"

namespace weft::partition {

using meshing::Adjacency;
using meshing::kNoNeighbour;

namespace {

using OpenFace = BackgroundPiece::OpenFace;

bool by_name(const OpenFace& a, const OpenFace& b) { return a.name < b.name; }

/// Names are hashes: with a bucket for each, by their leading bits (the first one is set in all), they are
/// nearly in order; a quarter of the time of std::sort.
std::vector<OpenFace> in_order(const std::vector<OpenFace>& faces) {
  if (faces.size() < 2) return faces;
  const int bits = std::bit_width(faces.size() - 1);
  const auto bucket = [&](const OpenFace& f) { return f.name << 1 >> (64 - bits); };
  std::vector<std::uint32_t> begins((std::size_t{1} << bits) + 1, 0);
  for (const OpenFace& f : faces) ++begins[bucket(f) + 1];
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<OpenFace> sorted(faces.size());
  for (const OpenFace& f : faces) sorted[begins[bucket(f)]++] = f;
  for (std::size_t i = 1; i < sorted.size(); ++i)
    for (std::size_t k = i; k > 0 && by_name(sorted[k], sorted[k - 1]); --k)
      std::swap(sorted[k], sorted[k - 1]);
  return sorted;
}

/// The faces without a neighbour, by name; ids[i] is the name of point i.
std::vector<OpenFace> border_of(std::span<const std::array<std::uint32_t, 4>> tets,
                                std::span<const std::array<std::uint32_t, 4>> neighbours,
                                std::span<const GlobalId> ids) {
  std::vector<OpenFace> border;
  for (std::uint32_t t = 0; t < tets.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      if (neighbours[t][f] != kNoNeighbour) continue;
      std::array<GlobalId, 3> v;
      for (std::size_t i = 0; i < 3; ++i) v[i] = ids[tets[t][meshing::kTetFaces[f][i]]];
      std::sort(v.begin(), v.end());
      const GlobalId name = GlobalId::derived_from(GlobalId::derived_from(v[0], v[1]), v[2]);
      border.push_back({name.value(), 4 * t + f});
    }
  return in_order(border);
}

/// The vertices of one piece after the other, numbered in the order in which its tets name them.
class PieceVertices {
 public:
  explicit PieceVertices(std::size_t num_vertices) : place_(num_vertices, kNowhere) {}

  /// The tets of the next piece by the numbers of its vertices.
  std::vector<std::array<std::uint32_t, 4>> number(std::span<const std::array<std::uint32_t, 4>> tets) {
    vertices_.clear();
    std::vector<std::array<std::uint32_t, 4>> numbered;
    numbered.reserve(tets.size());
    for (const auto& t : tets)
      numbered.push_back({place_of(t[0]), place_of(t[1]), place_of(t[2]), place_of(t[3])});
    for (const std::uint32_t v : vertices_) place_[v] = kNowhere;
    return numbered;
  }
  /// Of that piece.
  std::span<const std::uint32_t> vertices() const { return vertices_; }

 private:
  static constexpr std::uint32_t kNowhere = 0xFFFFFFFFu;

  std::uint32_t place_of(std::uint32_t vertex) {
    std::uint32_t& place = place_[vertex];
    if (place == kNowhere) {
      place = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertex);
    }
    return place;
  }

  std::vector<std::uint32_t> place_;  ///< of the vertices in the piece
  std::vector<std::uint32_t> vertices_;
};

/// Cuts one piece after the other; what lies beyond their faces is the caller's.
class Cutting {
 public:
  Cutting(std::span<const meshing::Point> points, std::span<const meshing::LogMetric> log_metrics,
          std::span<const GlobalId> ids)
      : points_(points), log_metrics_(log_metrics), ids_(ids), vertices_(points.size()) {}

  /// `neighbours`: of these tets by their numbers among them, kNoNeighbour at the border.
  std::shared_ptr<const BackgroundPiece> cut(
      std::uint64_t id, std::span<const std::array<std::uint32_t, 4>> tets,
      const std::function<std::vector<std::array<std::uint32_t, 4>>(const BackgroundPieceParts&)>&
          neighbours) {
    BackgroundPieceParts parts;
    parts.id = id;
    parts.tets = vertices_.number(tets);
    const std::span<const std::uint32_t> vertices = vertices_.vertices();
    std::vector<GlobalId> names;
    names.reserve(vertices.size());
    parts.points.reserve(vertices.size());
    parts.log_metrics.reserve(vertices.size());
    for (const std::uint32_t v : vertices) {
      parts.points.push_back(points_[v]);
      parts.log_metrics.push_back(log_metrics_[v]);
      names.push_back(ids_[v]);
    }
    parts.neighbours = neighbours(parts);
    parts.border = border_of(parts.tets, parts.neighbours, names);
    for (std::uint32_t i = 0; i < parts.border.size(); ++i) {
      const std::uint64_t code = parts.border[i].code;
      parts.neighbours[code >> 2][code & 3] = meshing::BackgroundBlock::kOpen | i;
    }
    return std::make_shared<const BackgroundPiece>(parts);
  }

 private:
  std::span<const meshing::Point> points_;
  std::span<const meshing::LogMetric> log_metrics_;
  std::span<const GlobalId> ids_;
  PieceVertices vertices_;
};

/// Calls f(first tet, tets of a piece), one piece after the other.
template <class F>
void for_each_piece(std::span<const std::array<std::uint32_t, 4>> tets, const F& f) {
  for (std::size_t first = 0; first < tets.size(); first += kTetsOfPiece)
    f(first, tets.subspan(first, std::min(kTetsOfPiece, tets.size() - first)));
}

/// Of tets that follow each other, among themselves.
std::vector<std::array<std::uint32_t, 4>> neighbours_within(const Adjacency& adjacency, std::size_t first,
                                                            std::size_t count) {
  const auto begin = adjacency.neighbours.begin() + static_cast<std::ptrdiff_t>(first);
  std::vector<std::array<std::uint32_t, 4>> within(begin, begin + static_cast<std::ptrdiff_t>(count));
  for (auto& tet : within)
    for (std::uint32_t& code : tet)
      code = code / 4 < first || code / 4 >= first + count ? kNoNeighbour
                                                           : code - 4 * static_cast<std::uint32_t>(first);
  return within;
}

/// At the beginning of a piece's bytes; the lists follow in the order of for_each_list(). All of them are of
/// elements that are some times 8 bytes.
struct Head {
  std::uint64_t id;
  std::array<std::uint64_t, 5> sizes;
};

template <class Piece, class F>
void for_each_list(Piece& p, const F& f) {
  f(p.points), f(p.log_metrics), f(p.border), f(p.tets), f(p.neighbours);
}

}  // namespace

BackgroundPiece::BackgroundPiece(const BackgroundPieceParts& parts) {
  Head head{parts.id, {}};
  std::size_t size = sizeof head, i = 0;
  for_each_list(parts, [&](const auto& list) {
    head.sizes[i++] = list.size();
    size += list.size() * sizeof(list[0]);
  });
  const auto words = std::make_shared<std::vector<std::uint64_t>>(size / 8);
  auto* at = reinterpret_cast<std::byte*>(words->data());
  const auto put = [&](const void* data, std::size_t bytes) {
    if (bytes > 0) std::memcpy(at, data, bytes);
    at += bytes;
  };
  put(&head, sizeof head);
  for_each_list(parts, [&](const auto& list) { put(list.data(), list.size() * sizeof(list[0])); });
  bytes_ = std::as_bytes(std::span(*words));
  owner_ = words;
  find_parts();
}

BackgroundPiece::BackgroundPiece(std::span<const std::byte> bytes, std::shared_ptr<const void> owner)
    : bytes_(bytes), owner_(std::move(owner)) {
  find_parts();
}

void BackgroundPiece::find_parts() {
  Head head{};
  std::size_t next = sizeof head, i = 0;
  const auto require = [&](bool holds) {
    if (!holds) throw std::runtime_error("a piece of the background does not have the size that it says");
  };
  require(bytes_.size() >= next);
  std::memcpy(&head, bytes_.data(), sizeof head);
  id = head.id;
  for_each_list(*this, [&]<class T>(std::span<const T>& list) {
    static_assert(sizeof(T) % 8 == 0 && alignof(T) <= 8);
    const std::uint64_t count = head.sizes[i++];
    require(count <= (bytes_.size() - next) / sizeof(T));
    list = {reinterpret_cast<const T*>(bytes_.data() + next), count};
    next += count * sizeof(T);
  });
  require(next == bytes_.size());
}

std::vector<std::shared_ptr<const BackgroundPiece>> cut_background(
    std::uint64_t first_id, std::span<const meshing::Point> points,
    std::span<const meshing::LogMetric> log_metrics, std::span<const GlobalId> ids,
    std::span<const std::array<std::uint32_t, 4>> tets) {
  Cutting cutting(points, log_metrics, ids);
  std::vector<std::shared_ptr<const BackgroundPiece>> pieces;
  for_each_piece(tets, [&](std::size_t, std::span<const std::array<std::uint32_t, 4>> of_piece) {
    pieces.push_back(cutting.cut(first_id + pieces.size(), of_piece, [](const BackgroundPieceParts& piece) {
      return meshing::build_adjacency(piece.tets, piece.points.size()).neighbours;
    }));
  });
  return pieces;
}

BackgroundStore::BackgroundStore(SubdomainId subdomain, std::span<const meshing::Point> points,
                                 std::span<const meshing::LogMetric> log_metrics,
                                 std::span<const GlobalId> ids,
                                 std::span<const std::array<std::uint32_t, 4>> tets,
                                 const Adjacency& adjacency) {
  Cutting cutting(points, log_metrics, ids);
  for_each_piece(tets, [&](std::size_t first, std::span<const std::array<std::uint32_t, 4>> of_piece) {
    append(cutting.cut(
        std::uint64_t{subdomain.value} << 32 | pieces_.size(), of_piece,
        [&](const BackgroundPieceParts&) { return neighbours_within(adjacency, first, of_piece.size()); }));
    const BackgroundPiece& piece = *pieces_.back();
    for (std::size_t i = 0; i < piece.border.size(); ++i) {
      const std::uint64_t code = piece.border[i].code;
      const std::uint32_t other = adjacency.neighbours[first + (code >> 2)][code & 3];
      across_.back()[i] = other;
      if (other == kNoNeighbour)
        border_.push_back({piece.border[i].name, std::uint64_t{pieces_.size() - 1} << 32 | i});
    }
  });
  border_ = in_order(border_);
  refer_to_pieces();
}

void BackgroundStore::add(std::span<const SharedPiece> pieces) {
  std::vector<OpenFace> open;
  for (const SharedPiece& piece : pieces) {
    if (has(piece->id)) continue;
    for (std::size_t i = 0; i < piece->border.size(); ++i)
      open.push_back({piece->border[i].name, std::uint64_t{pieces_.size()} << 32 | i});
    append(piece);
  }
  join_faces(std::move(open));
  refer_to_pieces();
}

void BackgroundStore::append(SharedPiece piece) {
  slot_.emplace(piece->id, static_cast<std::uint32_t>(pieces_.size()));
  across_.emplace_back(piece->border.size(), kNoNeighbour);
  pieces_.push_back(std::move(piece));
}

/// Among the background's faces.
std::uint32_t BackgroundStore::code_of(const OpenFace& face) const {
  const std::uint64_t place = face.code >> 32, in_border = face.code & 0xFFFFFFFFu;
  return static_cast<std::uint32_t>(4 * kTetsOfPiece * place + pieces_[place]->border[in_border].code);
}

/// Joins open faces with their other sides, among them or in the border; the rest becomes border.
void BackgroundStore::join_faces(std::vector<OpenFace> open) {
  open = in_order(open);
  std::vector<OpenFace> all;
  all.reserve(border_.size() + open.size());
  std::merge(border_.begin(), border_.end(), open.begin(), open.end(), std::back_inserter(all), by_name);
  border_.clear();
  for (const OpenFace& face : all) {
    if (border_.empty() || border_.back().name != face.name) {
      border_.push_back(face);
      continue;
    }
    across(face) = code_of(border_.back());
    across(border_.back()) = code_of(face);
    border_.pop_back();
  }
  border_.shrink_to_fit();
}

/// Anew whenever there are others.
void BackgroundStore::refer_to_pieces() {
  std::vector<meshing::BackgroundBlock> blocks;
  blocks.reserve(pieces_.size());
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const BackgroundPiece& piece = *pieces_[i];
    blocks.push_back({.points = piece.points.data(),
                      .log_metrics = piece.log_metrics.data(),
                      .tets = piece.tets.data(),
                      .neighbours = piece.neighbours.data(),
                      .across = across_[i].data(),
                      .num_tets = static_cast<std::uint32_t>(piece.tets.size())});
  }
  background_ = std::make_unique<meshing::Background>(std::move(blocks));
}

void BackgroundStore::share(SharedPieces<BackgroundPiece>& of_rank) {
  if (of_rank.share(pieces_)) refer_to_pieces();
}

std::vector<BackgroundStore::SharedPiece> BackgroundStore::pieces(std::span<const std::uint64_t> ids) const {
  std::vector<SharedPiece> found;
  for (const SharedPiece& piece : pieces_)
    if (std::ranges::binary_search(ids, piece->id)) found.push_back(piece);
  return found;
}

std::vector<std::uint64_t> BackgroundStore::piece_ids() const {
  std::vector<std::uint64_t> ids;
  for (const SharedPiece& piece : pieces_) ids.push_back(piece->id);
  std::ranges::sort(ids);
  return ids;
}

}  // namespace weft::partition
