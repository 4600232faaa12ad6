// Cutting, naming and joining of background pieces.
#include "partition/subdomain/background_store.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <numeric>
#include <utility>

#include "meshing/mesh/face_matcher.h"
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

  /// The tets of the next piece by the numbers of its vertices, counted on from `first`.
  void number(std::span<const std::array<std::uint32_t, 4>> tets, std::uint32_t first,
              std::vector<std::array<std::uint32_t, 4>>& numbered) {
    vertices_.clear();
    for (const auto& t : tets)
      numbered.push_back(
          {first + place_of(t[0]), first + place_of(t[1]), first + place_of(t[2]), first + place_of(t[3])});
    for (const std::uint32_t v : vertices_) place_[v] = kNowhere;
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

/// Calls f(tets of a piece), one piece after the other.
template <class F>
void for_each_piece(std::span<const std::array<std::uint32_t, 4>> tets, const F& f) {
  for (std::size_t first = 0; first < tets.size(); first += kTetsOfPiece)
    f(tets.subspan(first, std::min(kTetsOfPiece, tets.size() - first)));
}

}  // namespace

void BackgroundPiece::find_neighbours() {
  neighbours.assign(tets.size(), {kNoNeighbour, kNoNeighbour, kNoNeighbour, kNoNeighbour});
  meshing::FaceMatcher faces(points.size());
  for (std::uint32_t t = 0; t < tets.size(); ++t)
    for (std::uint32_t f = 0; f < 4; ++f) {
      const auto& corners = meshing::kTetFaces[f];
      const std::uint32_t code = 4 * t + f;
      const std::uint32_t other =
          faces.match({tets[t][corners[0]], tets[t][corners[1]], tets[t][corners[2]]}, code);
      if (other == kNoNeighbour) continue;
      neighbours[t][f] = other;
      neighbours[other >> 2][other & 3] = code;
    }
}

std::vector<std::shared_ptr<const BackgroundPiece>> cut_background(
    std::uint64_t first_id, std::span<const meshing::Point> points,
    std::span<const meshing::LogMetric> log_metrics, std::span<const GlobalId> ids,
    std::span<const std::array<std::uint32_t, 4>> tets) {
  PieceVertices vertices(points.size());
  std::vector<std::shared_ptr<const BackgroundPiece>> pieces;
  for_each_piece(tets, [&](std::span<const std::array<std::uint32_t, 4>> of_piece) {
    auto piece = std::make_shared<BackgroundPiece>();
    piece->id = first_id + pieces.size();
    piece->tets.reserve(of_piece.size());
    vertices.number(of_piece, 0, piece->tets);
    std::vector<GlobalId> names;
    for (const std::uint32_t v : vertices.vertices()) {
      piece->points.push_back(points[v]);
      piece->log_metrics.push_back(log_metrics[v]);
      names.push_back(ids[v]);
    }
    piece->neighbours = meshing::build_adjacency(piece->tets, piece->points.size()).neighbours;
    piece->border = border_of(piece->tets, piece->neighbours, names);
    pieces.push_back(std::move(piece));
  });
  return pieces;
}

BackgroundStore::BackgroundStore(SubdomainId subdomain, std::span<const meshing::Point> points,
                                 std::span<const meshing::LogMetric> log_metrics,
                                 std::span<const GlobalId> ids,
                                 std::span<const std::array<std::uint32_t, 4>> tets, Adjacency adjacency) {
  PieceVertices vertices(points.size());
  mesh_->tets.reserve(tets.size());
  for_each_piece(tets, [&](std::span<const std::array<std::uint32_t, 4>> of_piece) {
    const std::uint64_t id = std::uint64_t{subdomain.value} << 32 | joined_.size();
    const auto first_point = static_cast<std::uint32_t>(mesh_->points.size());
    const auto first_tet = static_cast<std::uint32_t>(mesh_->tets.size());
    place_.emplace(id, first_tet);
    joined_.push_back({id, first_point, first_tet, {}, {}});
    vertices.number(of_piece, first_point, mesh_->tets);
    for (const std::uint32_t v : vertices.vertices()) {
      mesh_->points.push_back(points[v]);
      log_metrics_->push_back(log_metrics[v]);
      names_.push_back(ids[v]);
    }
  });
  border_ = border_of(mesh_->tets, adjacency.neighbours, names_);
  background_ = std::make_unique<meshing::Background>(*mesh_, *log_metrics_, std::move(adjacency));
}

void BackgroundStore::add(std::span<const SharedPiece> pieces) {
  Adjacency adjacency;
  std::vector<OpenFace> open;
  if (background_) adjacency = background_->release_adjacency();
  make_room(pieces, adjacency);
  for (const auto& piece : pieces) {
    if (has(piece->id)) continue;
    const auto first_tet = static_cast<std::uint32_t>(mesh_->tets.size());
    place_.emplace(piece->id, first_tet);
    joined_.push_back(
        {piece->id, static_cast<std::uint32_t>(mesh_->points.size()), first_tet, piece->border, piece});
    for (const OpenFace& face : piece->border)
      open.push_back({face.name, face.code + 4 * std::uint64_t{first_tet}});
    append(*piece, adjacency);
  }
  join_faces(std::move(open), adjacency);
  background_ = std::make_unique<meshing::Background>(*mesh_, *log_metrics_, std::move(adjacency));
}

/// What arrives later is mostly little, and every subdomain would keep what it has too much.
void BackgroundStore::make_room(std::span<const SharedPiece> pieces, Adjacency& adjacency) {
  std::size_t points = mesh_->points.size(), tets = mesh_->tets.size();
  for (const auto& piece : pieces) points += piece->points.size(), tets += piece->tets.size();
  if (points > mesh_->points.capacity()) {
    mesh_->points.reserve(points + points / 4);
    log_metrics_->reserve(points + points / 4);
  }
  if (tets > mesh_->tets.capacity()) {
    mesh_->tets.reserve(tets + tets / 4);
    adjacency.neighbours.reserve(tets + tets / 4);
  }
}

void BackgroundStore::append(const BackgroundPiece& piece, Adjacency& adjacency) {
  const auto first_point = static_cast<std::uint32_t>(mesh_->points.size());
  const auto first_tet = static_cast<std::uint32_t>(mesh_->tets.size());
  mesh_->points.insert(mesh_->points.end(), piece.points.begin(), piece.points.end());
  log_metrics_->insert(log_metrics_->end(), piece.log_metrics.begin(), piece.log_metrics.end());
  mesh_->tets.insert(mesh_->tets.end(), piece.tets.begin(), piece.tets.end());
  for (auto& tet : std::span(mesh_->tets).subspan(first_tet))
    for (std::uint32_t& v : tet) v += first_point;
  adjacency.neighbours.insert(adjacency.neighbours.end(), piece.neighbours.begin(), piece.neighbours.end());
  for (auto& tet : std::span(adjacency.neighbours).subspan(first_tet))
    for (std::uint32_t& code : tet) code += code == kNoNeighbour ? 0 : 4 * first_tet;
}

/// Joins open faces with their other sides, among them or in the border; the rest becomes border.
void BackgroundStore::join_faces(std::vector<OpenFace> open, Adjacency& adjacency) {
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
    const auto a = static_cast<std::uint32_t>(face.code), b = static_cast<std::uint32_t>(border_.back().code);
    adjacency.neighbours[a >> 2][a & 3] = b;
    adjacency.neighbours[b >> 2][b & 3] = a;
    border_.pop_back();
  }
}

BackgroundStore::SharedPiece BackgroundStore::piece(std::size_t place) const {
  const Joined& joined = joined_[place];
  if (SharedPiece there = joined.copy.lock()) return there;
  const bool last = place + 1 == joined_.size();
  const auto end_point = last ? mesh_->points.size() : joined_[place + 1].first_point;
  const auto end_tet = last ? mesh_->tets.size() : joined_[place + 1].first_tet;
  const auto of_piece = [](const auto& all, std::size_t begin, std::size_t end) {
    return std::vector(all.begin() + static_cast<std::ptrdiff_t>(begin),
                       all.begin() + static_cast<std::ptrdiff_t>(end));
  };
  auto piece = std::make_shared<BackgroundPiece>();
  piece->id = joined.id;
  piece->points = of_piece(mesh_->points, joined.first_point, end_point);
  piece->log_metrics = of_piece(*log_metrics_, joined.first_point, end_point);
  piece->tets = of_piece(mesh_->tets, joined.first_tet, end_tet);
  for (auto& tet : piece->tets)
    for (std::uint32_t& v : tet) v -= joined.first_point;
  const auto& neighbours = background_->adjacency().neighbours;
  const std::uint32_t first_code = 4 * joined.first_tet, end_code = 4 * static_cast<std::uint32_t>(end_tet);
  piece->neighbours = of_piece(neighbours, joined.first_tet, end_tet);
  for (auto& tet : piece->neighbours)
    for (std::uint32_t& code : tet)
      code = code < first_code || code >= end_code ? kNoNeighbour : code - first_code;
  if (joined.border.empty())  // it was cut here, and nobody has asked for it yet
    joined.border = border_of(piece->tets, piece->neighbours, std::span(names_).subspan(joined.first_point));
  piece->border = joined.border;
  joined.copy = piece;
  return piece;
}

std::vector<BackgroundStore::SharedPiece> BackgroundStore::pieces(std::span<const std::uint64_t> ids) const {
  std::vector<SharedPiece> found;
  for (std::size_t i = 0; i < joined_.size(); ++i)
    if (std::ranges::binary_search(ids, joined_[i].id)) found.push_back(piece(i));
  return found;
}

std::vector<std::uint64_t> BackgroundStore::piece_ids() const {
  std::vector<std::uint64_t> ids;
  for (const Joined& joined : joined_) ids.push_back(joined.id);
  std::ranges::sort(ids);
  return ids;
}

BackgroundTet BackgroundStore::name_of(std::uint32_t tet) const {
  const auto after = std::ranges::upper_bound(joined_, tet, {}, &Joined::first_tet);
  const Joined& joined = *std::prev(after);
  return {joined.id, tet - joined.first_tet};
}

}  // namespace weft::partition
