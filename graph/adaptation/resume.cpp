// Records of all ranks of the checkpoint, read by those that are to have them now.
#include "graph/adaptation/resume.h"

#include <bit>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

#include "meshing/base/error.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/distribute/tet_records.h"

namespace weft::graph::adaptation {
namespace {

using Kind = CheckpointRecord::Kind;

template <class T>
std::uint64_t hash_of(std::span<const T> values, std::uint64_t seed) {
  static_assert(std::is_floating_point_v<T> || std::has_unique_object_representations_v<T> ||
                std::is_same_v<T, meshing::Point> || std::is_same_v<T, meshing::LogMetric>);
  return hash_bytes(values.data(), values.size() * sizeof(T), seed);
}
template <class T>
std::uint64_t hash_of(const std::vector<T>& values, std::uint64_t seed) {
  return hash_of(std::span<const T>(values), seed);
}

std::uint64_t hash_of(const AdaptationPlan& plan) {
  std::vector<std::uint64_t> words = {plan.subdomains,
                                      plan.most_shifts,
                                      static_cast<std::uint64_t>(plan.shift.layers),
                                      plan.shift.by_faces,
                                      plan.shift.fewer_later,
                                      plan.refine_interface,
                                      plan.pauses,
                                      plan.tets_at_frozen_stay,
                                      plan.allowed.insert,
                                      plan.allowed.swap,
                                      plan.allowed.move,
                                      std::bit_cast<std::uint64_t>(plan.hausd),
                                      std::bit_cast<std::uint64_t>(plan.details),
                                      std::bit_cast<std::uint64_t>(plan.expected_complexity)};
  for (const Phase& phase : plan.phases) {
    words.push_back(phase.first_round);
    words.push_back(std::bit_cast<std::uint64_t>(phase.coarseness));
  }
  const partition::Partitioner& by = plan.division_options.partitioner;
  words.insert(words.end(),
               {static_cast<std::uint64_t>(by.kind), by.slabs[0], by.slabs[1], by.slabs[2], by.principal_axes,
                by.fewer, plan.division_options.equal_tets, static_cast<std::uint64_t>(by.coordinate.kind)});
  for (const std::int32_t ref : by.coordinate.refs) words.push_back(static_cast<std::uint64_t>(ref));
  for (const partition::SubdomainId seed : plan.seeds) words.push_back(seed.value);
  return hash_of(words, 0);
}

/// Calls `use` with each record of a kind, of all files, that is for a subdomain of this rank.
void for_records_here(const CheckpointPlace& place, const AdaptationPlan& plan, int rank, int ranks,
                      Kind kind, const std::function<void(engine::Payload)>& use) {
  for (std::size_t file = 0; file < place.manifest.file_sizes.size(); ++file) {
    const CheckpointReader reader(place.folder / rank_file(static_cast<int>(file)));
    for (const CheckpointRecord& record : reader.index()) {
      if (record.kind != kind) continue;
      const auto subdomain = subdomain_of(plan, ranks, record.object);
      if (!subdomain)
        throw meshing::InputError(place.folder.string(), "",
                                  "has an object that is no subdomain of this run");
      if (partition::home_rank(*subdomain, plan.subdomains, ranks) == rank) use(reader.read(record));
    }
  }
}

}  // namespace

std::uint64_t hash_of_run(partition::Peers& peers, std::span<const partition::SubdomainStart> starts,
                          const AdaptationPlan& plan, std::uint64_t program) {
  std::uint64_t sum = 0;  // of all ranks: in no order
  for (const partition::SubdomainStart& s : starts) {
    std::uint64_t hash = s.subdomain.value;
    hash = hash_of(s.points, hash);
    hash = hash_of(s.log_metrics, hash);
    hash = hash_of(s.ids, hash);
    hash = hash_of(s.tets, hash);
    hash = hash_of(s.point_refs, hash);
    hash = hash_of(s.kinds, hash);
    hash = hash_of(s.flags, hash);
    hash = hash_of(s.boundary_faces, hash);
    hash = hash_of(s.feature_edges, hash);
    for (const auto& piece : s.background) hash = hash_of(piece->log_metrics, hash ^ piece->id);
    sum += hash_of(s.tet_refs, hash);
  }
  return partition::sum(peers, sum) ^ hash_of(plan) ^ program;
}

/// All is read before anything is made of it: a run of the engine in between would begin to work on it.
void restore_subdomains(engine::Runtime& runtime, partition::Peers& peers, const AdaptationPlan& plan,
                        const CheckpointPlace& place) {
  const int rank = peers.rank(), ranks = peers.ranks();
  std::vector<engine::Payload> objects, messages;
  partition::agree_on(peers, [&] {
    for_records_here(place, plan, rank, ranks, Kind::object,
                     [&](engine::Payload copy) { objects.push_back(std::move(copy)); });
    for_records_here(place, plan, rank, ranks, Kind::message,
                     [&](engine::Payload copy) { messages.push_back(std::move(copy)); });
  });
  if (partition::sum(peers, std::uint64_t{objects.size()}) != plan.subdomains)
    throw meshing::InputError(place.folder.string(), "", "lacks subdomains");
  for (std::uint32_t s = 0; s < plan.subdomains; ++s) {
    const partition::SubdomainId subdomain(s);
    runtime.restore_location(object_of(plan, ranks, subdomain).id,
                             engine::Rank(partition::home_rank(subdomain, plan.subdomains, ranks)));
  }
  for (engine::Payload& copy : objects) runtime.restore_object(std::move(copy));
  dataflow::forget_logs<SubdomainTask>(runtime);
  for (engine::Payload& copy : messages) runtime.restore_message(std::move(copy));
}

}  // namespace weft::graph::adaptation
