// Records of all pieces on every rank: a few for each entity of the model that a piece lies on.
#include "partition/output/sum_on_model.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

namespace weft::partition {
namespace {

using meshing::ModelEntitySums;
using meshing::ModelNormalSums;
using meshing::ModelSums;

struct EntityRecord {
  std::uint64_t subdomain;
  ModelEntitySums sums;
};

struct NormalRecord {
  std::uint64_t subdomain;
  ModelNormalSums sums;
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
}

std::vector<ModelNormalSums> summed_normals(Peers& peers, const std::vector<NormalRecord>& mine) {
  const auto key = [](const NormalRecord& r) { return std::tuple(r.sums.face, r.sums.ref, r.subdomain); };
  std::vector<ModelNormalSums> all;
  for (const NormalRecord& r : gathered(peers, mine, key)) {
    if (all.empty() || all.back().face != r.sums.face || all.back().ref != r.sums.ref) all.emplace_back();
    all.back().add(r.sums);
  }
  return all;
}

}  // namespace

ModelSums sum_on_model(Peers& peers, std::span<const PieceOnModel> mine) {
  std::vector<EntityRecord> entities;
  std::vector<NormalRecord> normals;
  std::vector<TotalRecord> totals;
  for (const auto& [subdomain, s] : mine) {
    totals.push_back(
        {subdomain.value, s.vertices, s.triangles, s.unclassified_triangles, s.off, s.distance, s.largest});
    for (const ModelEntitySums& e : s.entities) entities.push_back({subdomain.value, e});
    for (const ModelNormalSums& n : s.normals) normals.push_back({subdomain.value, n});
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
  sums.normals = summed_normals(peers, normals);
  return sums;
}

}  // namespace weft::partition
