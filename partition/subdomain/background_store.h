// The background of one subdomain: the pieces of the input mesh, or of another one that has the metric, that
// its tets cover, and more of them as tets arrive.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <ranges>
#include <span>
#include <unordered_map>
#include <vector>

#include "meshing/metric/background.h"
#include "partition/subdomain/global_id.h"
#include "partition/subdomain/shared_pieces.h"

namespace weft::partition {

/// What a piece is made of.
struct BackgroundPieceParts {
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
  /// Of the tets, as meshing::Adjacency; at the piece's border BackgroundBlock::kOpen and the place in
  /// `border`.
  std::vector<std::array<std::uint32_t, 4>> neighbours;
};

/// Some hundreds of tets of the background's mesh with their metric, cut out once and never changed: the unit
/// in which the background travels with the tets that cover it. One block of bytes: copies of a piece share
/// it, and so do messages.
struct BackgroundPiece {
  using OpenFace = BackgroundPieceParts::OpenFace;

  explicit BackgroundPiece(const BackgroundPieceParts& parts);
  /// Of bytes() of another; `owner` keeps them, aligned as a double is. Throws std::runtime_error where they
  /// do not have the size that they say.
  BackgroundPiece(std::span<const std::byte> bytes, std::shared_ptr<const void> owner);

  std::uint64_t id = 0;
  // As in BackgroundPieceParts:
  std::span<const meshing::Point> points;
  std::span<const meshing::LogMetric> log_metrics;
  std::span<const OpenFace> border;
  std::span<const std::array<std::uint32_t, 4>> tets, neighbours;

  std::span<const std::byte> bytes() const { return bytes_; }
  const std::shared_ptr<const void>& owner() const { return owner_; }

 private:
  void find_parts();

  std::span<const std::byte> bytes_;
  std::shared_ptr<const void> owner_;
};

/// Messages share the pieces' bytes, and pieces that are unpacked share the message's. `pieces` is a range of
/// pointers to pieces.
template <class Archive, class Pieces>
void serialize_pieces(Archive& archive, Pieces&& pieces) {
  std::uint64_t count = std::ranges::size(pieces);
  archive(count);
  if constexpr (Archive::kPacks) {
    for (const auto& piece : pieces) archive.share(piece->bytes(), piece->owner());
  } else {
    for (std::uint64_t i = 0; i < count; ++i) {
      auto [bytes, owner] = archive.shared();
      pieces.push_back(std::make_shared<const BackgroundPiece>(bytes, std::move(owner)));
    }
  }
}

/// Small enough that a parcel takes little more background than it needs, large enough that the faces between
/// pieces, which have to be matched, are few.
inline constexpr std::size_t kTetsOfPiece = meshing::BackgroundBlock::kMostTets;

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
/// when pieces are added. The pieces may be others' too (share()): its own is how they are joined.
class BackgroundStore {
 public:
  using SharedPiece = std::shared_ptr<const BackgroundPiece>;

  BackgroundStore() = default;

  /// Cuts the start of a subdomain into pieces, as cut_background(), and joins them: their faces are matched
  /// already in `adjacency`, that of the tets, which keep their numbers. `tets` must be in an order in which
  /// neighbours are near each other.
  BackgroundStore(SubdomainId subdomain, std::span<const meshing::Point> points,
                  std::span<const meshing::LogMetric> log_metrics, std::span<const GlobalId> ids,
                  std::span<const std::array<std::uint32_t, 4>> tets, const meshing::Adjacency& adjacency);

  /// Whether it is another mesh than the input: its faces and the input's have nothing in common.
  bool of_another_mesh() const { return !pieces_.empty() && (pieces_.front()->id & kOfAnotherMesh) != 0; }

  /// Joins pieces; those that are here already are passed over.
  void add(std::span<const SharedPiece> pieces);

  bool has(std::uint64_t piece) const { return slot_.contains(piece); }
  std::size_t num_pieces() const { return pieces_.size(); }
  /// Of those that are here, in the order in which they came; `ids` ascend.
  std::vector<SharedPiece> pieces(std::span<const std::uint64_t> ids) const;
  /// In the order in which they came.
  std::span<const SharedPiece> all_pieces() const { return pieces_; }
  /// Of all pieces, ascending.
  std::vector<std::uint64_t> piece_ids() const;

  BackgroundTet name_of(std::uint32_t tet) const {
    return {pieces_[tet / kTetsOfPiece]->id, static_cast<std::uint32_t>(tet % kTetsOfPiece)};
  }
  std::uint32_t tet_of(const BackgroundTet& name) const {
    return slot_.at(name.piece) * static_cast<std::uint32_t>(kTetsOfPiece) + name.tet;
  }

  const meshing::Background& background() const { return *background_; }

  /// Puts the rank's copies in the place of its own.
  void share(SharedPieces<BackgroundPiece>& of_rank);

 private:
  using OpenFace = BackgroundPiece::OpenFace;

  void append(SharedPiece piece);
  std::uint32_t& across(const OpenFace& face) { return across_[face.code >> 32][face.code & 0xFFFFFFFFu]; }
  std::uint32_t code_of(const OpenFace& face) const;
  void join_faces(std::vector<OpenFace> open);
  void refer_to_pieces();

  std::vector<SharedPiece> pieces_;
  std::unordered_map<std::uint64_t, std::uint32_t> slot_;  ///< id of a piece -> its place
  std::vector<std::vector<std::uint32_t>> across_;         ///< [place][open face]: meshing::BackgroundBlock
  std::vector<OpenFace> border_;  ///< what is still open, by name; codes: place and place in its border
  std::unique_ptr<meshing::Background> background_;
};

}  // namespace weft::partition
