#include "partition/output/common_file.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <vector>

#include "partition/communication/agreement.h"
#include "partition/communication/even_shares.h"

namespace weft::partition {
namespace {

/// Neighbouring ranks share a writer, the first of them; all writers have as many ranks, but for one. As many
/// exchanges as a group has others hand over what these have, so groups do not grow with the ranks.
struct Group {
  static constexpr int kMostRanks = 8;
  explicit Group(const Peers& peers) {
    const int ranks = peers.ranks(),
              writers =
                  std::min(ranks, std::max(peers.most_writers(), (ranks + kMostRanks - 1) / kMostRanks));
    const EvenShares groups(static_cast<std::uint64_t>(ranks), writers);
    const auto mine = groups.rank_of(static_cast<std::uint64_t>(peers.rank()));
    first = static_cast<int>(groups.first(mine));
    end = static_cast<int>(groups.first(mine + 1));
    largest = (ranks + writers - 1) / writers;
  }
  int first, end;  ///< this rank's; the first writes
  int largest;     ///< ranks of any group
};

}  // namespace

void CommonFile::create(Peers& peers) {
  temporary_ = text_of_first_or_throw(peers, [&] {
    file_ = std::make_unique<meshing::AtomicFile>(name_);
    return file_->temporary().string();
  });
  writes_ = Group(peers).first == peers.rank();
}

/// One rank of each writer's after the other: no writer holds more than one rank's bytes beside its own.
void CommonFile::deliver(Peers& peers) {
  const Group group(peers);
  if (group.largest == 1) return;
  std::optional<meshing::FilePart> out;
  std::exception_ptr failure;
  for (int turn = 1; turn < group.largest; ++turn) {
    const int from = group.first + turn;
    std::vector<Bytes> to_each(static_cast<std::size_t>(peers.ranks()));
    if (peers.rank() == from) to_each[static_cast<std::size_t>(group.first)] = std::exchange(kept_, {});
    const std::vector<Bytes> arrived = peers.all_to_all(std::move(to_each));
    if (!writes_ || failure || from >= group.end) continue;
    try {
      if (!out) out.emplace(target());
      out->write_kept(arrived[static_cast<std::size_t>(from)]);
    } catch (...) {
      failure = std::current_exception();
    }
  }
  agree_on(peers, [&] {
    if (failure) std::rethrow_exception(failure);
    if (out) out->finish();
  });
}

}  // namespace weft::partition
