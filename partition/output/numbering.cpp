// Counts go to everyone; numbers of vertices that others own are asked for at the vertices' homes.
#include "partition/output/numbering.h"

#include <algorithm>
#include <cstddef>
#include <sstream>
#include <string>
#include <unordered_map>

#include "meshing/base/parallel.h"
#include "meshing/base/release.h"
#include "partition/communication/agreement.h"
#include "partition/communication/home_rank.h"

namespace weft::partition {
namespace {

using meshing::gmf::MeshCounts;

/// The counts of one kind after the other, for loops over all kinds.
constexpr std::uint64_t MeshCounts::*kKinds[] = {&MeshCounts::points,
                                                 &MeshCounts::edges,
                                                 &MeshCounts::triangles,
                                                 &MeshCounts::tets,
                                                 &MeshCounts::corners,
                                                 &MeshCounts::ridges,
                                                 &MeshCounts::required_points,
                                                 &MeshCounts::required_edges,
                                                 &MeshCounts::required_triangles,
                                                 &MeshCounts::on_nodes,
                                                 &MeshCounts::on_edges,
                                                 &MeshCounts::on_faces};

std::string issue_about(const MeshPiece& piece) {
  const meshing::MeshData& mesh = piece.mesh;
  const std::size_t n = mesh.points.size();
  const bool fits = piece.ids.size() == n && piece.log_metrics.size() == n && mesh.point_refs.size() == n &&
                    mesh.tet_refs.size() == mesh.tets.size() &&
                    mesh.triangle_refs.size() == mesh.triangles.size() &&
                    mesh.edge_refs.size() == mesh.edges.size();
  return fits ? "" : "subdomain " + std::to_string(piece.subdomain.value) + ": arrays differ in length";
}

std::uint64_t count_set(const std::vector<std::uint8_t>& flags) {
  return static_cast<std::uint64_t>(std::count(flags.begin(), flags.end(), 1));
}

/// How many indices of a list are of entities with a flag.
std::uint64_t count_set(const std::vector<std::uint32_t>& list, const std::vector<std::uint8_t>& flags) {
  return static_cast<std::uint64_t>(
      std::count_if(list.begin(), list.end(), [&](std::uint32_t i) { return flags[i] != 0; }));
}

MeshCounts own_counts(const meshing::MeshData& mesh, const PieceShare& share) {
  return {.points = count_set(share.points),
          .edges = count_set(share.edges),
          .triangles = count_set(share.triangles),
          .tets = mesh.tets.size(),
          .corners = count_set(share.corners),
          .ridges = count_set(mesh.ridges, share.edges),
          .required_points = count_set(share.required_points),
          .required_edges = count_set(mesh.required_edges, share.edges),
          .required_triangles = count_set(mesh.required_triangles, share.triangles),
          .on_nodes = count_set(share.on_nodes),
          .on_edges = count_set(share.on_edges),
          .on_faces = count_set(share.on_faces)};
}

struct SubdomainCounts {
  std::uint64_t subdomain;
  MeshCounts counts;
};

/// Fills totals and the first numbers of the pieces here. Refuses two pieces of one subdomain: all ranks see
/// them.
void sum_counts(Peers& peers, std::span<const MeshPiece> mine, Numbering& numbering) {
  std::vector<SubdomainCounts> here(mine.size());
  meshing::for_each_large(mine.size(), [&](std::size_t p) {
    here[p] = {mine[p].subdomain.value, own_counts(mine[p].mesh, numbering.pieces[p].share)};
  });
  std::vector<SubdomainCounts> all = allgather_joined(peers, here);
  std::ranges::sort(all, {}, &SubdomainCounts::subdomain);
  const auto twin = std::ranges::adjacent_find(all, {}, &SubdomainCounts::subdomain);
  if (twin != all.end())
    throw_issue("subdomain " + std::to_string(twin->subdomain) + ": there are two pieces of it");
  std::unordered_map<std::uint64_t, MeshCounts> firsts;
  for (const SubdomainCounts& part : all) {
    firsts[part.subdomain] = numbering.totals;
    for (const auto kind : kKinds) numbering.totals.*kind += part.counts.*kind;
  }
  for (std::size_t p = 0; p < mine.size(); ++p)
    numbering.pieces[p].first = firsts.at(mine[p].subdomain.value);
}

constexpr std::uint64_t kUnknown = ~std::uint64_t{0};

void number_own_points(PieceNumbers& piece) {
  std::uint64_t next = piece.first.points;
  piece.points.assign(piece.share.points.size(), kUnknown);
  for (std::size_t v = 0; v < piece.points.size(); ++v) {
    if (piece.share.points[v]) piece.points[v] = next++;
  }
}

struct PointNumber {
  EntityKey<1> key;
  std::uint64_t number;  ///< kUnknown: asks for it
};

/// Brings the numbers of the vertices that others own.
void number_others_points(Peers& peers, std::span<const MeshPiece> mine, std::vector<PieceNumbers>& pieces) {
  std::vector<std::vector<std::uint32_t>> shared(mine.size());  // vertices of each piece
  std::vector<std::vector<PointNumber>> records(mine.size());
  meshing::for_each_large(mine.size(), [&](std::size_t p) {
    const std::vector<std::uint8_t> flags = shared_flags(mine[p]);
    for (std::uint32_t v = 0; v < flags.size(); ++v) {
      if (!flags[v]) continue;
      shared[p].push_back(v);
      records[p].push_back({{mine[p].ids[v]}, pieces[p].points[v]});
    }
  });
  Rendezvous<1, PointNumber> mail(peers.ranks());
  mail.add(std::vector<std::span<const PointNumber>>(records.begin(), records.end()));
  meshing::release(records);
  const auto arrived = mail.deliver(peers);
  std::vector<std::vector<std::uint64_t>> answers(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r) answers[r].resize(arrived[r].size());
  for_each_key<1>(arrived, [&](std::span<const Arrival> copies) {
    std::uint64_t number = kUnknown;
    for (const Arrival& at : copies) number = std::min(number, arrived[at.rank][at.index].number);
    for (const Arrival& at : copies) answers[at.rank][at.index] = number;
  });
  const std::vector<std::uint64_t> mine_answered = mail.answer(peers, std::move(answers));
  std::vector<std::size_t> begins{0};  // of the pieces' answers
  for (const auto& vertices : shared) begins.push_back(begins.back() + vertices.size());
  meshing::for_each_large(mine.size(), [&](std::size_t p) {
    for (std::size_t i = 0; i < shared[p].size(); ++i)
      pieces[p].points[shared[p][i]] = mine_answered[begins[p] + i];
  });
}

std::string issue_about_points(std::span<const MeshPiece> mine, const std::vector<PieceNumbers>& pieces) {
  for (std::size_t p = 0; p < mine.size(); ++p) {
    const auto unknown = std::ranges::find(pieces[p].points, kUnknown);
    if (unknown == pieces[p].points.end()) continue;
    std::ostringstream text;
    text << "subdomain " << mine[p].subdomain.value << ": vertex "
         << mine[p].ids[static_cast<std::size_t>(unknown - pieces[p].points.begin())]
         << " is not in the lowest subdomain that should hold it";
    return text.str();
  }
  return {};
}

}  // namespace

Numbering number_pieces(Peers& peers, std::span<const MeshPiece> mine) {
  std::string issue;
  for (const MeshPiece& piece : mine) issue = issue.empty() ? issue_about(piece) : issue;
  agree(peers, issue);
  Numbering numbering;
  for (PieceShare& share : shares_of(peers, mine)) numbering.pieces.push_back({std::move(share), {}, {}});
  sum_counts(peers, mine, numbering);
  meshing::for_each_large(mine.size(), [&](std::size_t p) { number_own_points(numbering.pieces[p]); });
  number_others_points(peers, mine, numbering.pieces);
  agree(peers, issue_about_points(mine, numbering.pieces));
  return numbering;
}

}  // namespace weft::partition
