// Each piece by itself; then what several pieces have, at its home.
#include "partition/verify/check_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

#include "meshing/base/compensated_sum.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/mesh/problems.h"
#include "partition/communication/home_rank.h"
#include "partition/output/piece_share.h"
#include "partition/verify/check_faces.h"

namespace weft::partition {
namespace {

using meshing::CompensatedSum;
using meshing::Problems;

// --- Arrays of one piece

void check_ids(const MeshPiece& piece, Problems& problems) {
  std::vector<GlobalId> ids = piece.ids;
  std::ranges::sort(ids);
  if (!ids.empty() && !ids[0].valid())
    problems.add("subdomain ", piece.subdomain.value, ": a vertex has no global id");
  for (std::size_t i = 1; i < ids.size(); ++i)
    if (ids[i] == ids[i - 1])
      problems.add("subdomain ", piece.subdomain.value, ": two vertices have the global id ", ids[i]);
}

void check_shared(const MeshPiece& piece, Problems& problems) {
  for (std::size_t i = 0; i < piece.shared.size(); ++i) {
    const auto& [vertex, other] = piece.shared[i];
    if (vertex >= piece.mesh.points.size() || other == piece.subdomain)
      problems.add("subdomain ", piece.subdomain.value, ": holders of vertices ", i + 1, ": names vertex ",
                   vertex + 1, " and subdomain ", other.value);
    if (i > 0 && !(piece.shared[i - 1] < piece.shared[i]))
      problems.add("subdomain ", piece.subdomain.value, ": holders of vertices ", i + 1, ": are not sorted");
  }
}

void check_one(const MeshPiece& piece, Problems& problems) {
  const std::size_t n = piece.mesh.points.size();
  if (piece.ids.size() != n || piece.log_metrics.size() != n)
    problems.add("subdomain ", piece.subdomain.value, ": ", piece.ids.size(), " global ids and ",
                 piece.log_metrics.size(), " metrics for ", n, " vertices");
  Problems of_mesh = problems.fresh();
  meshing::check_arrays(piece.mesh, of_mesh);
  problems.append(std::move(of_mesh), "subdomain " + std::to_string(piece.subdomain.value) + ": ");
  check_ids(piece, problems);
  check_shared(piece, problems);
}

// --- At home

/// All records of all ranks whose home is here, in a fixed order of `order(record)`.
template <std::size_t N, class Record, class Order>
std::vector<Record> gathered(Peers& peers, Rendezvous<N, Record>& mail, const Order& order) {
  std::vector<Record> records;
  for (const auto& of_rank : mail.deliver(peers))
    records.insert(records.end(), of_rank.begin(), of_rank.end());
  std::ranges::sort(records, {}, order);
  return records;
}

/// Calls visit(begin, end) for each group of records with one key.
template <class Record, class Visit>
void for_each_group(const std::vector<Record>& records, const Visit& visit) {
  const Record* const last = records.data() + records.size();
  for (const Record* begin = records.data(); begin != last;) {
    const Record* end = begin;
    while (end != last && end->key == begin->key) ++end;
    visit(begin, end);
    begin = end;
  }
}

constexpr auto kByKeyAndSubdomain = [](const auto& record) { return std::tie(record.key, record.subdomain); };

void check_all_faces(Peers& peers, std::span<const MeshPiece> mine, Problems& problems) {
  Rendezvous<3, OpenFace> mail(peers.ranks());
  for (const MeshPiece& piece : mine)
    for (const OpenFace& face : check_faces(piece, problems)) mail.add(face);
  for_each_group(gathered(peers, mail, kByKeyAndSubdomain),
                 [&](const OpenFace* begin, const OpenFace* end) { check_open_face(begin, end, problems); });
}

struct PlacedTet {
  EntityKey<4> key;
  std::uint64_t subdomain, tet;
};

void check_twin_tets(Peers& peers, std::span<const MeshPiece> mine, Problems& problems) {
  Rendezvous<4, PlacedTet> mail(peers.ranks());
  for (const MeshPiece& piece : mine)
    for (std::size_t t = 0; t < piece.mesh.tets.size(); ++t) {
      const auto& [a, b, c, d] = piece.mesh.tets[t];
      mail.add({sorted_key<4>({piece.ids[a], piece.ids[b], piece.ids[c], piece.ids[d]}),
                piece.subdomain.value, t});
    }
  const auto order = [](const PlacedTet& p) { return std::tie(p.key, p.subdomain, p.tet); };
  for_each_group(gathered(peers, mail, order), [&](const PlacedTet* begin, const PlacedTet* end) {
    for (const PlacedTet* twin = begin + 1; twin < end; ++twin)
      problems.add("tet ", begin->tet + 1, " of subdomain ", begin->subdomain, " and tet ", twin->tet + 1,
                   " of subdomain ", twin->subdomain, ": have the same vertices");
  });
}

struct VertexCopy {
  EntityKey<1> key;
  std::uint64_t subdomain;
  meshing::Point point;
  meshing::LogMetric log_metric;
};

/// What one copy says about another holder.
struct NamedHolder {
  EntityKey<1> key;
  std::uint64_t subdomain, other;
};

/// Bits, not values: -0 is not 0 here.
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

void check_copies(std::span<const VertexCopy> copies, Problems& problems) {
  for (const VertexCopy& copy : copies.subspan(1)) {
    if (copy.subdomain == copies[0].subdomain)
      problems.add("vertex ", copy.key[0], ": two pieces of subdomain ", copy.subdomain, " have it");
    const bool moved = !same_bits(copy.point, copies[0].point);
    if (!moved && same_bits(copy.log_metric, copies[0].log_metric)) continue;
    problems.add("vertex ", copy.key[0], ": its copies in subdomains ", copies[0].subdomain, " and ",
                 copy.subdomain, " differ in ", moved ? "place" : "metric");
  }
}

/// Both sorted by subdomain.
void check_holders(std::span<const VertexCopy> copies, std::span<const NamedHolder> named,
                   Problems& problems) {
  std::vector<std::array<std::uint64_t, 2>> says, is, difference;
  for (const NamedHolder& holder : named) says.push_back({holder.subdomain, holder.other});
  for (const VertexCopy& a : copies)
    for (const VertexCopy& b : copies)
      if (a.subdomain != b.subdomain) is.push_back({a.subdomain, b.subdomain});
  std::ranges::set_difference(says, is, std::back_inserter(difference));
  for (const auto& [subdomain, other] : difference)
    problems.add("vertex ", copies[0].key[0], ": subdomain ", subdomain, " names subdomain ", other,
                 ", which does not have it");
  difference.clear();
  std::ranges::set_difference(is, says, std::back_inserter(difference));
  for (const auto& [subdomain, other] : difference)
    problems.add("vertex ", copies[0].key[0], ": subdomain ", subdomain, " does not name subdomain ", other,
                 ", which has it too");
}

void check_vertices_of_pieces(Peers& peers, std::span<const MeshPiece> mine, Problems& problems) {
  Rendezvous<1, VertexCopy> copy_mail(peers.ranks());
  Rendezvous<1, NamedHolder> holder_mail(peers.ranks());
  for (const MeshPiece& piece : mine) {
    for (std::size_t v = 0; v < piece.ids.size(); ++v)
      copy_mail.add({{piece.ids[v]}, piece.subdomain.value, piece.mesh.points[v], piece.log_metrics[v]});
    for (const auto& [vertex, other] : piece.shared)
      holder_mail.add({{piece.ids[vertex]}, piece.subdomain.value, other.value});
  }
  const std::vector<VertexCopy> copies = gathered(peers, copy_mail, kByKeyAndSubdomain);
  const std::vector<NamedHolder> named = gathered(
      peers, holder_mail, [](const NamedHolder& h) { return std::tie(h.key, h.subdomain, h.other); });
  for_each_group(copies, [&](const VertexCopy* begin, const VertexCopy* end) {
    const auto of_vertex = std::ranges::equal_range(named, begin->key, {}, &NamedHolder::key);
    check_copies({begin, end}, problems);
    check_holders({begin, end}, {of_vertex.begin(), of_vertex.end()}, problems);
  });
}

// --- Sums

/// A part of a total: the volume of a piece's tets, or the area of its own triangles of one reference.
struct Part {
  std::uint64_t subdomain;
  std::int32_t is_area, ref;
  double value;
};

std::vector<Part> parts_of(const MeshPiece& piece, const PieceShare& own) {
  const auto& p = piece.mesh.points;
  CompensatedSum volume;
  for (const auto& [a, b, c, d] : piece.mesh.tets) volume.add(six_volume(p[a], p[b], p[c], p[d]) / 6);
  std::map<std::int32_t, CompensatedSum> areas;
  for (std::size_t t = 0; t < piece.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = piece.mesh.triangles[t];
    if (own.triangles[t]) areas[piece.mesh.triangle_refs[t]].add(norm(cross(p[b] - p[a], p[c] - p[a])) / 2);
  }
  std::vector<Part> parts{{piece.subdomain.value, 0, 0, volume.value()}};
  for (const auto& [ref, area] : areas) parts.push_back({piece.subdomain.value, 1, ref, area.value()});
  return parts;
}

void sum_sizes(Peers& peers, std::span<const MeshPiece> mine, PiecesReport& report) {
  const std::vector<PieceShare> shares = shares_of(peers, mine);
  std::vector<Part> parts;
  for (std::size_t p = 0; p < mine.size(); ++p)
    std::ranges::copy(parts_of(mine[p], shares[p]), std::back_inserter(parts));
  std::vector<Part> all = allgather_joined(peers, parts);
  std::ranges::stable_sort(all, {}, &Part::subdomain);
  CompensatedSum volume;
  std::map<std::int32_t, CompensatedSum> areas;
  for (const Part& part : all) (part.is_area ? areas[part.ref] : volume).add(part.value);
  report.volume = volume.value();
  for (const auto& [ref, area] : areas) report.area_by_ref[ref] = area.value();
}

void compare(const std::string& what, double found, double expected, double tolerance, Problems& problems) {
  if (std::abs(found - expected) <= 1e-9 * std::abs(expected) + tolerance) return;
  std::ostringstream numbers;
  numbers.precision(17);
  numbers << found << " instead of " << expected;
  problems.add(what, ": ", numbers.str());
}

void compare_totals(const PiecesReport& report, const ExpectedTotals& expected, Problems& problems) {
  compare("the volume", report.volume, expected.volume, expected.volume_tolerance, problems);
  if (!expected.areas_known) return;
  std::map<std::int32_t, std::array<double, 2>> areas;
  for (const auto& [ref, area] : report.area_by_ref) areas[ref][0] = area;
  for (const auto& [ref, area] : expected.area_by_ref) areas[ref][1] = area;
  for (const auto& [ref, pair] : areas)
    compare("the area of triangles of reference " + std::to_string(ref), pair[0], pair[1], 0, problems);
}

}  // namespace

void gather_problems(Peers& peers, Problems&& found, bool name_ranks, PiecesReport& report) {
  const std::size_t limit = found.limit();
  const std::uint64_t mine = found.count();
  for (const auto& count : allgather(peers, std::vector<std::uint64_t>{mine}))
    report.num_problems += count[0];
  std::vector<char> lines;
  const std::string where =
      name_ranks ? " (found on rank " + std::to_string(peers.rank()) + ")" : std::string();
  for (const std::string& sentence : found.take()) {
    lines.insert(lines.end(), sentence.begin(), sentence.end());
    lines.insert(lines.end(), where.begin(), where.end());
    lines.push_back('\n');
  }
  for (const auto& of_rank : allgather(peers, lines)) {
    std::istringstream text(std::string(of_rank.begin(), of_rank.end()));
    for (std::string line; std::getline(text, line);) report.problems.push_back(line);
  }
  std::ranges::sort(report.problems);
  if (report.problems.size() > limit) report.problems.resize(limit);
}

PiecesReport check_pieces(Peers& peers, std::span<const MeshPiece> mine,
                          const std::optional<ExpectedTotals>& expected, int max_problems, bool name_ranks) {
  const auto limit = static_cast<std::size_t>(std::max(max_problems, 0));
  PiecesReport report;
  Problems of_arrays(limit), problems(limit);
  for (const MeshPiece& piece : mine) check_one(piece, of_arrays);
  gather_problems(peers, std::move(of_arrays), name_ranks, report);
  if (!report.ok()) return report;
  check_all_faces(peers, mine, problems);
  check_twin_tets(peers, mine, problems);
  check_vertices_of_pieces(peers, mine, problems);
  sum_sizes(peers, mine, report);
  if (expected && peers.rank() == 0) compare_totals(report, *expected, problems);
  gather_problems(peers, std::move(problems), name_ranks, report);
  return report;
}

}  // namespace weft::partition
