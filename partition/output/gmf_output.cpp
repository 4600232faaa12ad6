// Counts give every row of a binary file its place; those of text are measured.
#include "partition/output/gmf_output.h"

#include <cstddef>
#include <string>

namespace weft::partition {

using meshing::GmfSliceWriter;

void GmfOutput::create(Peers& peers) {
  first_ = peers.rank() == 0;
  file_.create(peers);
  if (!plan_.is_text()) return;
  std::vector<std::uint64_t> heads;
  for (const std::string& head : plan_.text_heads()) heads.push_back(head.size());
  std::vector<TextLengths> lengths;
  for (const GmfPart& part : parts_) {
    GmfSliceWriter measures(plan_);
    part.write(measures);
    lengths.push_back({part.order, measures.text_places()});
  }
  places_ = place_text(peers, heads, lengths);
}

void GmfOutput::write() {
  GmfSliceWriter out(file_.target(), plan_);
  if (first_) out.frame(places_.heads);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    if (plan_.is_text()) out.set_text_places(places_.rows[p]);
    parts_[p].write(out);
  }
  out.finish();
}

}  // namespace weft::partition
