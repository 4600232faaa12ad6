// All ranks know the boxes of all pieces, ask for those that a box allows, and look at what comes.
#include "partition/surface/surface_pieces.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using Piece = meshing::SurfacePieces::Piece;

// So many pieces of some 20 KB a rank waits for at a time.
constexpr std::size_t kAtATime = 64;

struct PieceBox {
  std::uint32_t id, maker;
  meshing::Box box;
};

/// Ascending by id.
std::vector<PieceBox> all_boxes(Peers& peers, const meshing::SurfaceCutter* cutter) {
  std::vector<PieceBox> mine;
  if (cutter)
    for (const std::uint32_t id : cutter->ids())
      mine.push_back({id, static_cast<std::uint32_t>(peers.rank()), cutter->box(id)});
  std::vector<PieceBox> all = allgather_joined(peers, mine);
  std::ranges::sort(all, {}, &PieceBox::id);
  return all;
}

void append(const meshing::SurfacePiece& piece, Bytes& bytes) {
  const std::uint64_t size = piece.bytes().size();
  const auto* begin = reinterpret_cast<const std::byte*>(&size);
  bytes.insert(bytes.end(), begin, begin + sizeof size);
  bytes.insert(bytes.end(), piece.bytes().begin(), piece.bytes().end());
}

/// The piece at the beginning of `bytes`, which go on behind it.
Piece take_piece(std::span<const std::byte>& bytes) {
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  const auto words = std::make_shared<std::vector<std::uint64_t>>(size / 8);
  std::memcpy(words->data(), bytes.data() + sizeof size, size);
  bytes = bytes.subspan(sizeof size + size);
  return std::make_shared<const meshing::SurfacePiece>(std::as_bytes(std::span(*words)), words);
}

class HandOut {
 public:
  HandOut(Peers& peers, const meshing::SurfaceCutter* cutter, std::span<const SurfaceCover> covers)
      : peers_(peers), cutter_(cutter), covers_(covers), pieces_(covers.size()) {
    for (const PieceBox& piece : all_boxes(peers, cutter))
      if (std::ranges::any_of(covers_, [&](const auto& c) { return c.may_want(piece.id, piece.box); }))
        asked_.push_back(piece);
  }

  std::vector<std::vector<Piece>> run() {
    const std::size_t most = partition::max(peers_, std::uint64_t{asked_.size()});
    for (std::size_t first = 0; first < most; first += kAtATime) {
      const std::size_t begin = std::min(first, asked_.size());
      exchange(std::span(asked_).subspan(begin, std::min(kAtATime, asked_.size() - begin)));
    }
    for (auto& pieces : pieces_) std::ranges::sort(pieces, {}, [](const Piece& piece) { return piece->id; });
    return std::move(pieces_);
  }

 private:
  void exchange(std::span<const PieceBox> asked);
  void offer(const Piece& piece);

  Peers& peers_;
  const meshing::SurfaceCutter* cutter_;
  std::span<const SurfaceCover> covers_;
  std::vector<std::vector<Piece>> pieces_;  // by cover
  std::vector<PieceBox> asked_;             // ascending by id
};

void HandOut::offer(const Piece& piece) {
  for (std::size_t c = 0; c < covers_.size(); ++c)
    if (covers_[c].wants(*piece)) pieces_[c].push_back(piece);
}

void HandOut::exchange(std::span<const PieceBox> asked) {
  const auto me = static_cast<std::uint32_t>(peers_.rank());
  std::vector<std::vector<std::uint32_t>> to_each(static_cast<std::size_t>(peers_.ranks()));
  for (const PieceBox& piece : asked)
    if (piece.maker == me)
      offer(cutter_->piece(piece.id));
    else
      to_each[piece.maker].push_back(piece.id);
  const auto from_each = partition::all_to_all(peers_, std::move(to_each));
  std::vector<Bytes> answers(from_each.size());
  for (std::size_t r = 0; r < from_each.size(); ++r)
    for (const std::uint32_t id : from_each[r]) append(*cutter_->piece(id), answers[r]);
  for (const Bytes& arrived : peers_.all_to_all(std::move(answers)))
    for (std::span<const std::byte> rest(arrived); !rest.empty();) offer(take_piece(rest));
}

}  // namespace

std::vector<std::vector<Piece>> pieces_near(Peers& peers, const meshing::SurfaceCutter* cutter,
                                            std::span<const SurfaceCover> covers) {
  return HandOut(peers, cutter, covers).run();
}

void hand_out_pieces(Peers& peers, const meshing::SurfaceCutter* cutter, std::span<SubdomainStart> starts) {
  std::vector<SurfaceCover> covers;
  for (const SubdomainStart& start : starts) covers.push_back(cover_of(start));
  std::vector<std::vector<Piece>> pieces = pieces_near(peers, cutter, covers);
  for (std::size_t s = 0; s < starts.size(); ++s) starts[s].surface = std::move(pieces[s]);
}

}  // namespace weft::partition
