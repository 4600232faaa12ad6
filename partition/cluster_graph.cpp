// Clusters along a curve, their graph, and METIS: the only source that names it.
#include "partition/cluster_graph.h"

#include <metis.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>

#include "meshing/morton.h"
#include "meshing/tet_tables.h"
#include "partition/inertia.h"
#include "partition/ordered_cuts.h"
#include "partition/reduce.h"

namespace weft::partition {
namespace {

using Tet = std::array<std::uint32_t, 4>;

constexpr std::uint32_t kClustersPerSubdomain = 64, kLeastPerSubdomain = 8;

/// A face of a tet in a cluster; vertices ascending.
struct ClusterFace {
  std::array<std::uint32_t, 3> vertices;
  std::uint32_t cluster;
  friend auto operator<=>(const ClusterFace&, const ClusterFace&) = default;
};

/// That two clusters, first < second, share `faces` faces.
struct Joint {
  std::uint32_t first, second;
  std::uint64_t faces;
};

std::vector<std::uint64_t> morton_keys(Peers& peers, std::span<const meshing::Point> points) {
  const std::vector<std::uint32_t> together(points.size(), 0);
  const meshing::Box box = group_boxes(peers, points, together, 1)[0];
  const meshing::Vec size = box.size();
  const double longest = std::max({size.x, size.y, size.z});
  const double scale = longest > 0 ? 2097151 / longest : 0;  // 21 bits
  std::vector<std::uint64_t> keys;
  keys.reserve(points.size());
  for (const meshing::Point& p : points) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key |= meshing::spread_bits(static_cast<std::uint64_t>((p[k] - box.lo[k]) * scale)) << k;
    keys.push_back(key);
  }
  return keys;
}

/// Counts pairs of equal faces in different clusters into `joints` and returns the faces without an equal
/// one.
std::vector<ClusterFace> join(std::vector<ClusterFace> faces, std::vector<Joint>& joints) {
  std::sort(faces.begin(), faces.end());
  std::vector<ClusterFace> single;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + 1 == faces.size() || faces[i].vertices != faces[i + 1].vertices) {
      single.push_back(faces[i]);
      continue;
    }
    if (faces[i].cluster != faces[i + 1].cluster)
      joints.push_back({faces[i].cluster, faces[i + 1].cluster, 1});
    ++i;
  }
  return single;
}

/// Each pair of clusters once, sorted.
void merge(std::vector<Joint>& joints) {
  std::sort(joints.begin(), joints.end(), [](const Joint& a, const Joint& b) {
    return a.first != b.first ? a.first < b.first : a.second < b.second;
  });
  std::size_t kept = 0;
  for (const Joint& joint : joints) {
    if (kept > 0 && joints[kept - 1].first == joint.first && joints[kept - 1].second == joint.second)
      joints[kept - 1].faces += joint.faces;
    else
      joints[kept++] = joint;
  }
  joints.resize(kept);
}

/// All joints of all ranks, on rank 0; faces that no local face equals meet at the rank of their lowest
/// vertex.
std::vector<Joint> gather_joints(Peers& peers, std::span<const Tet> tets,
                                 std::span<const std::uint32_t> clusters) {
  std::vector<ClusterFace> faces;
  faces.reserve(4 * tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (const auto& f : meshing::kTetFaces) {
      faces.push_back({{tets[t][f[0]], tets[t][f[1]], tets[t][f[2]]}, clusters[t]});
      std::sort(faces.back().vertices.begin(), faces.back().vertices.end());
    }
  std::vector<Joint> joints;
  const auto ranks = static_cast<std::uint32_t>(peers.ranks());
  std::vector<std::vector<ClusterFace>> to_each(ranks);
  for (const ClusterFace& face : join(std::move(faces), joints))
    to_each[face.vertices[0] % ranks].push_back(face);
  std::vector<ClusterFace> met;
  for (const auto& part : partition::exchange(peers, to_each))
    met.insert(met.end(), part.begin(), part.end());
  join(std::move(met), joints);
  merge(joints);
  std::vector<std::vector<Joint>> to_first(ranks);
  to_first[0] = std::move(joints);
  joints.clear();
  for (const auto& part : partition::exchange(peers, to_first))
    joints.insert(joints.end(), part.begin(), part.end());
  merge(joints);
  return joints;
}

/// The graph in the arrays that METIS reads.
struct MetisGraph {
  std::vector<idx_t> begins, neighbours, edge_weights, vertex_weights;
};

/// In METIS's 32 bits, all together below 2^30.
std::vector<idx_t> small_weights(const std::vector<std::uint64_t>& weights) {
  std::uint64_t total = 0;
  for (const std::uint64_t w : weights) total += w;
  const int shift = std::max(0, static_cast<int>(std::bit_width(total)) - 29);
  std::vector<idx_t> result;
  for (const std::uint64_t w : weights)
    result.push_back(static_cast<idx_t>(std::max<std::uint64_t>(1, w >> shift)));
  return result;
}

MetisGraph metis_graph(const std::vector<Joint>& joints, const std::vector<std::uint64_t>& weights) {
  MetisGraph g;
  g.begins.assign(weights.size() + 1, 0);
  for (const Joint& j : joints) ++g.begins[j.first + 1], ++g.begins[j.second + 1];
  for (std::size_t c = 0; c < weights.size(); ++c) g.begins[c + 1] += g.begins[c];
  g.neighbours.resize(2 * joints.size());
  std::vector<std::uint64_t> faces(2 * joints.size());
  std::vector<idx_t> next(g.begins.begin(), g.begins.end() - 1);
  const auto add = [&](std::uint32_t from, std::uint32_t to, std::uint64_t weight) {
    const auto at = static_cast<std::size_t>(next[from]++);
    g.neighbours[at] = static_cast<idx_t>(to);
    faces[at] = weight;
  };
  for (const Joint& j : joints) add(j.first, j.second, j.faces), add(j.second, j.first, j.faces);
  g.edge_weights = small_weights(faces);
  g.vertex_weights = small_weights(weights);
  return g;
}

/// The part of each cluster; nothing where METIS fails.
std::vector<std::uint32_t> metis_parts(MetisGraph g, std::uint32_t num_parts) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;  // the same parts in every run
  auto num_vertices = static_cast<idx_t>(g.vertex_weights.size());
  auto parts_wanted = static_cast<idx_t>(num_parts);
  idx_t one_weight = 1, cut = 0;
  std::vector<idx_t> part(g.vertex_weights.size());
  const auto divide = num_parts <= 8 ? METIS_PartGraphRecursive : METIS_PartGraphKway;
  const int status =
      divide(&num_vertices, &one_weight, g.begins.data(), g.neighbours.data(), g.vertex_weights.data(),
             nullptr, g.edge_weights.data(), &parts_wanted, nullptr, nullptr, options, &cut, part.data());
  if (status != METIS_OK) return {};
  return {part.begin(), part.end()};
}

/// Rank 0's array on every rank.
std::vector<std::uint32_t> broadcast(Peers& peers, const std::vector<std::uint32_t>& from_first) {
  std::vector<std::vector<std::uint32_t>> to_each(static_cast<std::size_t>(peers.ranks()));
  if (peers.rank() == 0) std::fill(to_each.begin(), to_each.end(), from_first);
  return partition::exchange(peers, to_each)[0];
}

std::vector<std::uint32_t> curve_parts(Peers& peers, const WeightedItems& items, std::uint32_t num_parts) {
  const std::vector<std::uint64_t> keys = morton_keys(peers, items.centres);
  const std::vector<std::uint32_t> together(items.centres.size(), 0);
  return cut_groups(peers, {keys, items.numbers, items.weights}, together,
                    {std::vector<std::uint32_t>(num_parts, 1)});
}

}  // namespace

std::vector<SubdomainId> graph_partition(Peers& peers, const WeightedItems& items, std::span<const Tet> tets,
                                         std::uint32_t num_subdomains) {
  const auto count = partition::sum(peers, std::uint64_t{items.centres.size()});
  if (num_subdomains == 1 || count < std::uint64_t{kLeastPerSubdomain} * num_subdomains)
    return curve_parts(peers, items, num_subdomains);
  const auto num_clusters = static_cast<std::uint32_t>(std::min<std::uint64_t>(
      {std::uint64_t{kClustersPerSubdomain} * num_subdomains, count, std::numeric_limits<idx_t>::max() / 2}));
  std::vector<std::uint32_t> parts = curve_parts(peers, items, num_clusters);
  std::vector<std::uint64_t> weights(num_clusters, 0);
  for (std::size_t i = 0; i < parts.size(); ++i) weights[parts[i]] += items.weights[i];
  weights = partition::sum(peers, weights);
  const std::vector<Joint> joints = gather_joints(peers, tets, parts);
  std::vector<std::uint32_t> part_of_cluster;
  if (peers.rank() == 0) part_of_cluster = metis_parts(metis_graph(joints, weights), num_subdomains);
  part_of_cluster = broadcast(peers, part_of_cluster);
  if (part_of_cluster.empty())  // on all ranks alike: nobody waits for rank 0
    throw std::runtime_error("METIS could not divide the graph of clusters");
  for (std::uint32_t& part : parts) part = part_of_cluster[part];
  return parts;
}

}  // namespace weft::partition
