// Records of all pieces on every rank: a few for each entity of the model that a piece lies on.
#include "partition/output/sum_on_model.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

namespace weft::partition {
namespace {

using meshing::ModelEntitySums;
using meshing::ModelSums;

struct EntityRecord {
  std::uint64_t subdomain;
  ModelEntitySums sums;
};

struct TotalRecord {
  std::uint64_t subdomain, vertices, triangles, unclassified_triangles, off;
  double distance, largest;
};

/// Rounding follows the order.
template <class Record, class Key>
std::vector<Record> gathered(Peers& peers, const std::vector<Record>& mine, const Key& key) {
  std::vector<Record> all = allgather_joined(peers, mine);
  std::ranges::sort(all, {}, key);
  return all;
}

void add(ModelEntitySums& to, const ModelEntitySums& more) {
  to.vertices += more.vertices;
  to.measured += more.measured;
  to.distance += more.distance;
  to.largest = std::max(to.largest, more.largest);
  to.deviation = std::max(to.deviation, more.deviation);
  to.side += more.side;
  to.least_cosine = std::min(to.least_cosine, more.least_cosine);
  to.largest_cosine = std::max(to.largest_cosine, more.largest_cosine);
}

}  // namespace

ModelSums sum_on_model(Peers& peers, std::span<const PieceOnModel> mine) {
  std::vector<EntityRecord> entities;
  std::vector<TotalRecord> totals;
  for (const auto& [subdomain, s] : mine) {
    totals.push_back(
        {subdomain.value, s.vertices, s.triangles, s.unclassified_triangles, s.off, s.distance, s.largest});
    for (const ModelEntitySums& e : s.entities) entities.push_back({subdomain.value, e});
  }
  ModelSums sums;
  for (const TotalRecord& t : gathered(peers, totals, &TotalRecord::subdomain)) {
    sums.vertices += t.vertices;
    sums.triangles += t.triangles;
    sums.unclassified_triangles += t.unclassified_triangles;
    sums.off += t.off;
    sums.distance += t.distance;
    sums.largest = std::max(sums.largest, t.largest);
  }
  const auto key = [](const EntityRecord& r) { return std::tuple(r.sums.kind, r.sums.entity, r.subdomain); };
  for (const EntityRecord& r : gathered(peers, entities, key)) {
    if (!sums.entities.empty() && sums.entities.back().kind == r.sums.kind &&
        sums.entities.back().entity == r.sums.entity)
      add(sums.entities.back(), r.sums);
    else
      sums.entities.push_back(r.sums);
  }
  return sums;
}

}  // namespace weft::partition
