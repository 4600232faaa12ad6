#include "partition/output/common_file.h"

#include <cstddef>
#include <exception>
#include <optional>
#include <vector>

#include "partition/communication/agreement.h"

namespace weft::partition {
namespace {

/// So many neighbouring ranks have one that writes, the first of them.
int ranks_of_writer(const Peers& peers) {
  return (peers.ranks() + peers.most_writers() - 1) / peers.most_writers();
}

}  // namespace

void CommonFile::create(Peers& peers) {
  agree_on(peers, [&] {
    if (peers.rank() == 0) file_ = std::make_unique<meshing::AtomicFile>(name_);
  });
  temporary_ = text_of_first(peers, file_ ? file_->temporary().string() : "");
  writes_ = peers.rank() % ranks_of_writer(peers) == 0;
}

/// One rank of each writer's after the other: no writer holds more than one rank's bytes beside its own.
void CommonFile::deliver(Peers& peers) {
  const int group = ranks_of_writer(peers), place = peers.rank() % group, writer = peers.rank() - place;
  if (group == 1) return;
  std::optional<meshing::FilePart> out;
  std::exception_ptr failure;
  for (int turn = 1; turn < group; ++turn) {
    std::vector<Bytes> to_each(static_cast<std::size_t>(peers.ranks()));
    if (place == turn) to_each[static_cast<std::size_t>(writer)] = std::exchange(kept_, {});
    const std::vector<Bytes> arrived = peers.all_to_all(std::move(to_each));
    const int from = writer + turn;
    if (!writes_ || failure || from >= peers.ranks()) continue;
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
