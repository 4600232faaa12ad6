// Edges go to who forms their curves, from there to their places in the order of pieces, and home.
#include "partition/surface/feature_curves.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "meshing/base/release.h"
#include "partition/communication/at_home.h"
#include "partition/communication/ranges.h"
#include "partition/surface/joined_chains.h"

namespace weft::partition {
namespace {

using meshing::CurveId;
using meshing::FoundCurve;

constexpr std::uint64_t kInNoPiece = std::numeric_limits<std::uint64_t>::max();

/// Of what a rank has formed.
struct TaggedCurve {
  FoundCurve curve;
  std::uint32_t beside_pieces;
  std::uint32_t rank;
};

}  // namespace

FeatureCurves::FeatureCurves(Peers& peers, const std::vector<OwnFeature>& mine) : peers_(peers) {
  std::vector<meshing::FoundFeature> found;
  for (const OwnFeature& f : mine) found.push_back(f.found);
  const std::vector<std::size_t> homes = homes_of_curves(peers, found);
  std::vector<std::vector<OwnFeature>> to_each(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t f = 0; f < mine.size(); ++f) to_each[homes[f]].push_back(mine[f]);
  form(partition::all_to_all(peers, std::move(to_each)));
}

/// All ranks: of whole curves, from each rank.
void FeatureCurves::form(std::vector<std::vector<OwnFeature>> arrived) {
  struct Told {
    OwnFeature feature;
    std::uint32_t by;
  };
  std::vector<Told> all;
  for (std::uint32_t r = 0; r < arrived.size(); ++r) {
    for (const OwnFeature& f : arrived[r]) all.push_back({f, r});
    meshing::release(arrived[r]);
  }
  std::ranges::sort(all, {}, [](const Told& f) { return f.feature.found.vertices; });
  std::vector<bool> beside_pieces;  // by feature
  for (const Told& f : all) {
    here_.push_back(f.feature.found);
    told_by_.push_back(f.by);
    beside_pieces.push_back(f.feature.beside_pieces != 0);
  }
  meshing::release(all);
  meshing::FormedCurves formed = meshing::form_curves(here_);
  std::vector<std::uint8_t> beside(formed.curves.size(), 0);
  for (std::size_t f = 0; f < here_.size(); ++f)
    if (beside_pieces[f]) beside[formed.of_features[f].curve.value] = 1;
  on_ = std::move(formed.of_features);
  number_curves(std::move(formed.curves), std::move(beside));
}

/// All ranks: curves get their numbers among all.
void FeatureCurves::number_curves(std::vector<FoundCurve> formed, std::vector<std::uint8_t> beside) {
  const auto me = static_cast<std::uint32_t>(peers_.rank());
  std::vector<TaggedCurve> mine;
  for (std::size_t c = 0; c < formed.size(); ++c) mine.push_back({formed[c], beside[c], me});
  std::vector<TaggedCurve> all = allgather_joined(peers_, mine);
  std::ranges::sort(all, {}, [](const TaggedCurve& c) { return c.curve.order(); });
  std::vector<CurveId> numbers;  // of those formed here, which are in order
  for (const TaggedCurve& c : all) {
    if (c.rank == me) numbers.emplace_back(static_cast<std::uint32_t>(found_.size()));
    found_.push_back(c.curve);
    beside_pieces_.push_back(static_cast<std::uint8_t>(c.beside_pieces));
  }
  for (meshing::FeatureOnCurve& on : on_) on.curve = numbers[on.curve.value];
}

std::vector<FeatureCurves::FirstEdge> FeatureCurves::first_edges() const {
  std::vector<std::vector<FirstEdge>> to_each(static_cast<std::size_t>(peers_.ranks()));
  for (std::size_t f = 0; f < here_.size(); ++f)
    if (on_[f].first) to_each[told_by_[f]].push_back({here_[f].vertices, on_[f].curve});
  return all_to_all_joined(peers_, std::move(to_each));
}

/// All ranks: those that come to this rank, in order; those in no piece last.
std::vector<FeatureCurves::Keyed> FeatureCurves::in_order(const meshing::PieceOrder& order,
                                                          std::span<const std::uint64_t> firsts,
                                                          std::span<const std::uint8_t> in_pieces) {
  std::vector<std::vector<Keyed>> to_each(static_cast<std::size_t>(peers_.ranks()));
  for (std::size_t f = 0; f < here_.size(); ++f) {
    const std::uint64_t key = order.key(here_[f].ends);
    const auto rank = static_cast<std::size_t>(std::ranges::upper_bound(firsts, key) - firsts.begin());
    to_each[rank].push_back(
        {in_pieces[on_[f].curve.value] ? key : kInNoPiece, {here_[f].vertices, meshing::kNoName, 0, on_[f]}});
  }
  meshing::release(here_);
  meshing::release(on_);
  meshing::release(told_by_);
  std::vector<Keyed> all = all_to_all_joined(peers_, std::move(to_each));
  std::ranges::sort(all, {}, [](const Keyed& f) { return std::pair{f.key, f.record.vertices}; });
  return all;
}

void FeatureCurves::name(const meshing::PieceOrder& order, std::span<const std::uint64_t> firsts,
                         std::span<const std::uint8_t> in_pieces, std::uint32_t first_piece) {
  std::vector<Keyed> mine = in_order(order, firsts, in_pieces);
  const auto named =
      static_cast<std::size_t>(std::ranges::lower_bound(mine, kInNoPiece, {}, &Keyed::key) - mine.begin());
  const Ranges places(peers_, named);
  dealt_ = DealtPieces(places.total(), first_piece, peers_.ranks());
  std::vector<std::vector<FeatureRecord>> to_homes(static_cast<std::size_t>(peers_.ranks()));
  for (std::size_t i = 0; i < mine.size(); ++i) {
    FeatureRecord& record = mine[i].record;
    if (i < named) record.name = dealt_.name(places.first(peers_.rank()) + i);
    to_homes[record.vertices[0] % to_homes.size()].push_back(record);
  }
  meshing::release(mine);
  at_home_ = all_to_all_joined(peers_, std::move(to_homes));
  std::ranges::sort(at_home_, {}, &FeatureRecord::vertices);
}

std::vector<FeatureRecord> FeatureCurves::between(const std::vector<std::vector<std::uint32_t>>& asked,
                                                  const std::vector<std::uint32_t>& vertices) const {
  std::vector<FeatureRecord> found = told_between(peers_, asked, vertices, at_home_);
  std::ranges::sort(found, {}, &FeatureRecord::vertices);
  return found;
}

}  // namespace weft::partition
