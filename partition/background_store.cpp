// Cutting, naming and joining of background pieces.
#include "partition/background_store.h"

#include <algorithm>
#include <iterator>

#include "meshing/tet_tables.h"

namespace weft::partition {

using meshing::Adjacency;
using meshing::kNoNeighbour;

namespace {

/// Small enough that a parcel takes little more background than it needs, large enough that the faces between
/// pieces, which have to be matched, are few.
constexpr std::size_t kTetsOfPiece = 512;

bool by_name(const BackgroundPiece::OpenFace& a, const BackgroundPiece::OpenFace& b) {
  return a.name < b.name;
}

/// The faces without a neighbour in the piece; ids[i] is the name of its point i.
std::vector<BackgroundPiece::OpenFace> border_of(const BackgroundPiece& piece,
                                                 std::span<const GlobalId> ids) {
  std::vector<BackgroundPiece::OpenFace> border;
  for (std::uint32_t t = 0; t < piece.tets.size(); ++t)
    for (std::size_t f = 0; f < 4; ++f) {
      if (piece.neighbours[t][f] != kNoNeighbour) continue;
      std::array<GlobalId, 3> v;
      for (std::size_t i = 0; i < 3; ++i) v[i] = ids[piece.tets[t][meshing::kTetFaces[f][i]]];
      std::sort(v.begin(), v.end());
      const GlobalId name = GlobalId::derived_from(GlobalId::derived_from(v[0], v[1]), v[2]);
      border.push_back({name.value(), 4 * t + f});
    }
  std::sort(border.begin(), border.end(), by_name);
  return border;
}

/// Tets [first, first + count) as a piece of their own.
std::shared_ptr<const BackgroundPiece> cut_piece(std::uint64_t id, std::span<const meshing::Point> points,
                                                 std::span<const meshing::LogMetric> log_metrics,
                                                 std::span<const GlobalId> ids,
                                                 std::span<const std::array<std::uint32_t, 4>> tets) {
  auto piece = std::make_shared<BackgroundPiece>();
  piece->id = id;
  std::unordered_map<std::uint32_t, std::uint32_t> local;
  std::vector<GlobalId> names;
  piece->tets.reserve(tets.size());
  for (const auto& t : tets) {
    std::array<std::uint32_t, 4> mine;
    for (int i = 0; i < 4; ++i) {
      const auto [at, is_new] = local.try_emplace(t[i], static_cast<std::uint32_t>(piece->points.size()));
      if (is_new) {
        piece->points.push_back(points[t[i]]);
        piece->log_metrics.push_back(log_metrics[t[i]]);
        names.push_back(ids[t[i]]);
      }
      mine[i] = at->second;
    }
    piece->tets.push_back(mine);
  }
  piece->neighbours = meshing::build_adjacency(piece->tets, piece->points.size()).neighbours;
  piece->border = border_of(*piece, names);
  return piece;
}

}  // namespace

BackgroundStore::BackgroundStore(SubdomainId subdomain, std::span<const meshing::Point> points,
                                 std::span<const meshing::LogMetric> log_metrics,
                                 std::span<const GlobalId> ids,
                                 std::span<const std::array<std::uint32_t, 4>> tets) {
  std::vector<std::shared_ptr<const BackgroundPiece>> pieces;
  for (std::size_t first = 0; first < tets.size(); first += kTetsOfPiece) {
    const std::uint64_t id = std::uint64_t{subdomain} << 32 | pieces.size();
    pieces.push_back(cut_piece(id, points, log_metrics, ids,
                               tets.subspan(first, std::min(kTetsOfPiece, tets.size() - first))));
  }
  add(pieces);
}

void BackgroundStore::add(std::span<const std::shared_ptr<const BackgroundPiece>> pieces) {
  Adjacency adjacency;
  std::vector<OpenFace> open;
  if (background_) adjacency = background_->release_adjacency();
  for (const auto& piece : pieces) {
    if (has(piece->id)) continue;
    place_.emplace(piece->id, static_cast<std::uint32_t>(mesh_->tets.size()));
    begins_.push_back(static_cast<std::uint32_t>(mesh_->tets.size()));
    pieces_.push_back(piece);
    append(*piece, adjacency, open);
  }
  join_faces(std::move(open), adjacency);
  background_ = std::make_unique<meshing::Background>(*mesh_, *log_metrics_, std::move(adjacency));
}

void BackgroundStore::append(const BackgroundPiece& piece, Adjacency& adjacency,
                             std::vector<OpenFace>& open) {
  const auto first_point = static_cast<std::uint32_t>(mesh_->points.size());
  const auto first_tet = static_cast<std::uint32_t>(mesh_->tets.size());
  mesh_->points.insert(mesh_->points.end(), piece.points.begin(), piece.points.end());
  log_metrics_->insert(log_metrics_->end(), piece.log_metrics.begin(), piece.log_metrics.end());
  for (std::array<std::uint32_t, 4> t : piece.tets) {
    for (std::uint32_t& v : t) v += first_point;
    mesh_->tets.push_back(t);
  }
  for (std::array<std::uint32_t, 4> n : piece.neighbours) {
    for (std::uint32_t& code : n)
      if (code != kNoNeighbour) code += 4 * first_tet;
    adjacency.neighbours.push_back(n);
  }
  for (const OpenFace& face : piece.border) open.push_back({face.name, face.code + 4 * first_tet});
}

/// Joins open faces with their other sides, among them or in the border; the rest becomes border.
void BackgroundStore::join_faces(std::vector<OpenFace> open, Adjacency& adjacency) {
  std::sort(open.begin(), open.end(), by_name);
  std::vector<OpenFace> all;
  all.reserve(border_.size() + open.size());
  std::merge(border_.begin(), border_.end(), open.begin(), open.end(), std::back_inserter(all), by_name);
  border_.clear();
  for (const OpenFace& face : all) {
    if (border_.empty() || border_.back().name != face.name) {
      border_.push_back(face);
      continue;
    }
    const auto a = static_cast<std::uint32_t>(face.code), b = static_cast<std::uint32_t>(border_.back().code);
    adjacency.neighbours[a >> 2][a & 3] = b;
    adjacency.neighbours[b >> 2][b & 3] = a;
    border_.pop_back();
  }
}

std::vector<std::shared_ptr<const BackgroundPiece>> BackgroundStore::pieces(
    std::span<const std::uint64_t> ids) const {
  std::vector<std::shared_ptr<const BackgroundPiece>> found;
  for (const auto& piece : pieces_)
    if (std::binary_search(ids.begin(), ids.end(), piece->id)) found.push_back(piece);
  return found;
}

std::vector<std::uint64_t> BackgroundStore::piece_ids() const {
  std::vector<std::uint64_t> ids;
  for (const auto& piece : pieces_) ids.push_back(piece->id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

BackgroundTet BackgroundStore::name_of(std::uint32_t tet) const {
  const auto after = std::upper_bound(begins_.begin(), begins_.end(), tet);
  const std::size_t at = static_cast<std::size_t>(after - begins_.begin()) - 1;
  return {pieces_[at]->id, tet - begins_[at]};
}

}  // namespace weft::partition
