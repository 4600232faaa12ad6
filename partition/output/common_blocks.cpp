#include "partition/output/common_blocks.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

#include "meshing/base/parallel.h"
#include "meshing/io/files/file_part.h"

namespace weft::partition {
namespace {

/// Bytes of one block that one rank has; they follow it.
struct BlockPiece {
  std::uint64_t block, first_byte, bytes;
};

}  // namespace

std::vector<Bytes> CommonBlocks::pieces_of_blocks(const Peers& peers, const EvenShares& shares) const {
  std::vector<Bytes> to_each(static_cast<std::size_t>(peers.ranks()));
  const auto send = [&](std::uint64_t block, std::uint64_t first_byte, std::span<const std::byte> bytes) {
    const BlockPiece piece{block, first_byte, bytes.size()};
    Bytes& to = to_each[shares.rank_of(block)];
    append(to, &piece, sizeof piece);
    append(to, bytes.data(), bytes.size());
  };
  for_parts_([&](std::uint64_t, const meshing::MeshPart& part) { blocks_.for_rows(part, send); });
  if (peers.rank() == 0) blocks_.for_corners(send);
  return to_each;
}

void CommonBlocks::compress(std::vector<Bytes> pieces, std::uint64_t count) {
  std::vector<Bytes> blocks(count);
  for (std::size_t i = 0; i < blocks.size(); ++i) blocks[i].resize(blocks_.size(first_ + i));
  for (Bytes& of_rank : pieces) {
    for (std::size_t at = 0; at < of_rank.size();) {
      BlockPiece piece;
      std::memcpy(&piece, &of_rank[at], sizeof piece);
      at += sizeof piece;
      std::memcpy(&blocks[piece.block - first_][piece.first_byte], &of_rank[at], piece.bytes);
      at += piece.bytes;
    }
    of_rank = {};
  }
  compressed_.resize(blocks.size());
  meshing::for_each_large(blocks.size(), [&](std::size_t i) {
    compressed_[i] = meshing::VtuBlocks::compressed(std::exchange(blocks[i], {}));
  });
}

void CommonBlocks::create(Peers& peers) {
  file_.create(peers);
  const EvenShares shares(blocks_.count(), peers.ranks());
  first_ = shares.first(peers.rank());
  compress(peers.all_to_all(pieces_of_blocks(peers, shares)), shares.count(peers.rank()));
  std::vector<std::uint64_t> of_arrays(blocks_.num_arrays());
  for (std::size_t i = 0; i < compressed_.size(); ++i)
    of_arrays[blocks_.array_of(first_ + i)] += compressed_[i].size();
  const std::vector<std::vector<std::uint64_t>> of_ranks = allgather(peers, of_arrays);
  before_.assign(of_arrays.size(), 0);
  std::ranges::fill(of_arrays, 0);
  for (std::size_t r = 0; r < of_ranks.size(); ++r)
    for (std::size_t array = 0; array < of_arrays.size(); ++array) {
      if (r == static_cast<std::size_t>(peers.rank())) before_[array] = of_arrays[array];
      of_arrays[array] += of_ranks[r][array];
    }
  blocks_.place(of_arrays);
}

void CommonBlocks::write() {
  meshing::FilePart out(file_.target());
  if (file_.is_mine()) blocks_.write_frame(out);
  for (std::size_t i = 0; i < compressed_.size(); ++i) {
    const std::uint64_t block = first_ + i;
    std::uint64_t& before = before_[blocks_.array_of(block)];
    blocks_.write_block(out, block, before, compressed_[i]);
    before += compressed_[i].size();
  }
  out.finish();
}

}  // namespace weft::partition
