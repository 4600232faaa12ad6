#include "partition/output/common_text.h"

#include <cstddef>

#include "meshing/io/files/file_part.h"
#include "partition/communication/agreement.h"

namespace weft::partition {

void CommonText::create(Peers& peers) {
  file_.create(peers);
  agree_on(peers, [&] {
    if (peers.rank() == 0) heads_ = meshing::text_heads(file_.name(), whole_);
  });
  std::vector<std::uint64_t> head_sizes;
  for (const std::string& head : heads_) head_sizes.push_back(head.size());
  head_sizes = allgather(peers, head_sizes)[0];
  std::vector<TextLengths> lengths;
  for_parts_([&](std::uint64_t order, const meshing::MeshPart& part) {
    lengths.push_back({order, {}});
    const auto text = meshing::open_text_part(file_.name(), whole_, part);
    for (std::size_t section = 0; section < head_sizes.size(); ++section)
      lengths.back().sections.push_back(text->rows(section).size());
  });
  places_ = place_text(peers, head_sizes, lengths);
}

void CommonText::write() {
  meshing::FilePart out(file_.target());
  for (std::size_t section = 0; section < heads_.size(); ++section) {
    out.seek(places_.heads[section]);
    out.write(heads_[section]);
  }
  std::size_t p = 0;
  for_parts_([&](std::uint64_t, const meshing::MeshPart& part) {
    const auto text = meshing::open_text_part(file_.name(), whole_, part);
    for (std::size_t section = 0; section < places_.heads.size(); ++section) {
      out.seek(places_.rows[p][section]);
      out.write(text->rows(section));
    }
    ++p;
  });
  out.finish();
}

}  // namespace weft::partition
