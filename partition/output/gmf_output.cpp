// Counts give every row of a binary file its place; those of text are measured.
#include "partition/output/gmf_output.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "meshing/base/parallel.h"
#include "meshing/base/release.h"

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
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  std::vector<meshing::PlacedBytes> of_thread(std::clamp<std::size_t>(parts_.size(), 1, threads));
  meshing::PlacedBytes* const kept = of_thread.size() > 1 ? file_.target().kept : nullptr;
  meshing::for_each_large(of_thread.size(), [&](std::size_t k) {
    meshing::PartTarget target = file_.target();
    if (kept) target.kept = &of_thread[k];
    GmfSliceWriter out(target, plan_);
    if (first_ && k == 0) out.frame(places_.heads);
    for (std::size_t p = k; p < parts_.size(); p += of_thread.size()) {
      if (plan_.is_text()) out.set_text_places(places_.rows[p]);
      parts_[p].write(out);
    }
    out.finish();
  });
  if (!kept) return;
  for (meshing::PlacedBytes& bytes : of_thread) {
    kept->insert(kept->end(), bytes.begin(), bytes.end());
    meshing::release(bytes);
  }
}

}  // namespace weft::partition
