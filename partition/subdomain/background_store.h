// The background of one subdomain: the pieces of the input mesh, or of another one that has the metric, that
// its tets cover, and more of them as tets arrive.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <ranges>
#include <span>
#include <unordered_map>
#include <vector>

#include "meshing/metric/background.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// Some hundreds of tets of the background's mesh with their metric, cut out once and never changed: the unit
/// in which the background travels with the tets that cover it. Plain arrays.
struct BackgroundPiece {
  /// A face that has its other side, if any, in another piece.
  struct OpenFace {
    std::uint64_t name = 0;  ///< a hash of its vertices' global ids: the same on the other side
    std::uint64_t code = 0;  ///< as in meshing::Adjacency
  };

  std::uint64_t id = 0;
  std::vector<meshing::Point> points;
  std::vector<meshing::LogMetric> log_metrics;
  std::vector<OpenFace> border;  ///< by name
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::array<std::uint32_t, 4>>
      neighbours;  ///< as meshing::Adjacency; kNoNeighbour at the piece's border

  template <class Archive>
  void serialize(Archive& archive) {
    archive(id, points, log_metrics, border, tets);
    if constexpr (!Archive::kPacks) find_neighbours();
  }

 private:
  void find_neighbours();
};

/// Packs copies of shared pieces, or unpacks pieces to be shared. `pieces` is a range of pointers to pieces.
template <class Archive, class Pieces>
void serialize_pieces(Archive& archive, Pieces&& pieces) {
  std::uint64_t count = std::ranges::size(pieces);
  archive(count);
  if constexpr (Archive::kPacks) {
    for (const auto& piece : pieces) archive(*piece);
  } else {
    for (std::uint64_t i = 0; i < count; ++i) {
      auto piece = std::make_shared<BackgroundPiece>();
      archive(*piece);
      pieces.push_back(std::move(piece));
    }
  }
}

/// Small enough that a parcel takes little more background than it needs, large enough that the faces between
/// pieces, which have to be matched, are few.
inline constexpr std::size_t kTetsOfPiece = 512;

/// Pieces of a background that is another mesh than the input have ids with this bit.
inline constexpr std::uint64_t kOfAnotherMesh = std::uint64_t{1} << 63;

/// Cuts tets, in an order in which neighbours are near each other, into pieces with the ids from `first_id`
/// on.
std::vector<std::shared_ptr<const BackgroundPiece>> cut_background(
    std::uint64_t first_id, std::span<const meshing::Point> points,
    std::span<const meshing::LogMetric> log_metrics, std::span<const GlobalId> ids,
    std::span<const std::array<std::uint32_t, 4>> tets);

/// A tet of the background, named so that every subdomain understands it.
struct BackgroundTet {
  std::uint64_t piece = 0;
  std::uint32_t tet = 0;
};

/// Joined pieces, which answer as one meshing::Background. Tets keep their numbers (the hints of vertices)
/// when pieces are added. What is joined is kept, not the pieces: whoever asks for one gets a copy, the same
/// as others as long as somebody has it.
class BackgroundStore {
 public:
  using SharedPiece = std::shared_ptr<const BackgroundPiece>;

  BackgroundStore() = default;

  /// Cuts the start of a subdomain into pieces, as cut_background(), and joins them: their faces are matched
  /// already in `adjacency`, that of the tets. `tets` must be in an order in which neighbours are near each
  /// other.
  BackgroundStore(SubdomainId subdomain, std::span<const meshing::Point> points,
                  std::span<const meshing::LogMetric> log_metrics, std::span<const GlobalId> ids,
                  std::span<const std::array<std::uint32_t, 4>> tets, meshing::Adjacency adjacency);

  /// Whether it is another mesh than the input: its faces and the input's have nothing in common.
  bool of_another_mesh() const { return !joined_.empty() && (joined_.front().id & kOfAnotherMesh) != 0; }

  /// Joins pieces; those that are here already are passed over.
  void add(std::span<const SharedPiece> pieces);

  bool has(std::uint64_t piece) const { return place_.contains(piece); }
  std::size_t num_pieces() const { return joined_.size(); }
  /// Of those that are here, in the order in which they came; `ids` ascend.
  std::vector<SharedPiece> pieces(std::span<const std::uint64_t> ids) const;
  /// In the order in which they came, each made when it is looked at.
  auto all_pieces() const {
    return std::views::iota(std::size_t{0}, joined_.size()) |
           std::views::transform([this](std::size_t i) { return piece(i); });
  }
  /// Of all pieces, ascending.
  std::vector<std::uint64_t> piece_ids() const;

  BackgroundTet name_of(std::uint32_t tet) const;
  std::uint32_t tet_of(const BackgroundTet& name) const { return place_.at(name.piece) + name.tet; }

  const meshing::Background& background() const { return *background_; }

 private:
  using OpenFace = BackgroundPiece::OpenFace;

  /// What is known of a piece beside what has been joined.
  struct Joined {
    std::uint64_t id = 0;
    std::uint32_t first_point = 0, first_tet = 0;
    mutable std::vector<OpenFace> border;               ///< empty: not looked for yet
    mutable std::weak_ptr<const BackgroundPiece> copy;  ///< that somebody may have
  };

  SharedPiece piece(std::size_t place) const;
  void make_room(std::span<const SharedPiece> pieces, meshing::Adjacency& adjacency);
  void append(const BackgroundPiece& piece, meshing::Adjacency& adjacency);
  void join_faces(std::vector<OpenFace> open, meshing::Adjacency& adjacency);

  std::vector<Joined> joined_;
  std::unordered_map<std::uint64_t, std::uint32_t> place_;  ///< id of a piece -> its first tet
  std::vector<OpenFace> border_;                            ///< what is still open, by name
  std::vector<GlobalId> names_;                             ///< of the points of pieces that were cut here
  // Held by pointer: the background refers to them, and the store may move.
  std::unique_ptr<meshing::MeshData> mesh_ = std::make_unique<meshing::MeshData>();
  std::unique_ptr<std::vector<meshing::LogMetric>> log_metrics_ =
      std::make_unique<std::vector<meshing::LogMetric>>();
  std::unique_ptr<meshing::Background> background_;
};

}  // namespace weft::partition
