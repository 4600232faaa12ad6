#include "tools/library/parts/part_input.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "partition/communication/agreement.h"
#include "partition/communication/point_limit.h"
#include "partition/communication/ranges.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/parts/naming_rank.h"
#include "tools/library/parts/part_faces.h"
#include "tools/library/parts/part_numbers.h"

namespace weft::tools {
namespace {

using partition::MeshSlice;
using partition::Peers;

template <class... Pieces>
std::string text(const Pieces&... pieces) {
  std::ostringstream out;
  (out << ... << pieces);
  return std::move(out).str();
}

/// What a part must be by itself.
void check_part(const Part& part, const Metric* metric) {
  const WholeMesh whole(part.mesh);
  check_length(part.mesh, part.ids.size(), "list of ids");
  if (metric) check_length(part.mesh, metric->size(), "metric");
  check_fields(part.mesh, part.fields);
  if (!part.tet_ids.empty() && part.tet_ids.size() != part.mesh.tets.size())
    throw InputError("", "tet ids", text(part.tet_ids.size(), " for ", part.mesh.tets.size(), " tets"));
  std::vector<std::uint64_t> ids = part.ids;
  std::ranges::sort(ids);
  const auto twice = std::ranges::adjacent_find(ids);
  if (twice != ids.end()) throw InputError("", text("vertex id ", *twice), "stands for two of its vertices");
}

struct PointRecord {
  std::uint64_t id;
  Point x;
  Tensor log_metric;
  std::int64_t ref;
};

bool same(const PointRecord& a, const PointRecord& b) {
  return a.x == b.x && a.log_metric == b.log_metric && a.ref == b.ref;
}

/// A record at its home: where it came from.
struct Arrived {
  PointRecord record;
  std::size_t rank, index;
};

/// All ranks: fills the slice's points; returns the number of each of the part's points in the whole mesh.
std::vector<std::uint64_t> number_points(Peers& peers, const Part& part, const Mesh& mesh,
                                         const Metric* metric, MeshSlice& slice) {
  const IdHomes homes(peers, largest_id(part.ids));
  IdMail<PointRecord> mail(peers, homes);
  for (std::size_t v = 0; v < part.ids.size(); ++v)
    mail.add(part.ids[v],
             {part.ids[v], mesh.points[v], metric ? metric->logarithms()[v] : Tensor{}, mesh.point_refs[v]});
  const auto from_each = mail.deliver();
  std::vector<Arrived> all;
  std::vector<std::vector<std::uint64_t>> numbers(from_each.size());
  for (std::size_t r = 0; r < from_each.size(); ++r) {
    numbers[r].resize(from_each[r].size());
    for (std::size_t i = 0; i < from_each[r].size(); ++i) all.push_back({from_each[r][i], r, i});
  }
  std::ranges::stable_sort(all, {}, [](const Arrived& a) { return a.record.id; });
  std::string issue;
  for (std::size_t i = 0, first = 0; i < all.size(); ++i) {
    const PointRecord& record = all[i].record;
    if (i == 0 || record.id != all[first].record.id) {
      first = i;
      slice.points.push_back(record.x);
      slice.point_refs.push_back(static_cast<std::int32_t>(record.ref));
      if (metric) slice.log_metrics.push_back(record.log_metric);
    } else if (issue.empty() && !same(record, all[first].record)) {
      issue = text("rank ", all[i].rank, ": vertex id ", record.id, ": is another point than on rank ",
                   all[first].rank, ", or has another metric or reference");
    }
    numbers[all[i].rank][all[i].index] = slice.points.size() - 1;
  }
  partition::agree(peers, issue);
  const partition::Ranges ranges(peers, slice.points.size());
  slice.num_points = ranges.total();
  slice.first_point = ranges.first(peers.rank());
  for (auto& of_rank : numbers)
    for (std::uint64_t& number : of_rank) number += slice.first_point;
  partition::refuse_too_many_points(slice.num_points);
  return mail.answer(numbers);
}

struct TetRecord {
  std::uint64_t id;
  std::array<std::uint32_t, 4> vertices;
  std::int64_t ref;
};

/// All ranks: the tets in the order of their ids.
void order_tets(Peers& peers, const std::vector<TetRecord>& mine, MeshSlice& slice) {
  std::uint64_t largest = 0;
  for (const TetRecord& tet : mine) largest = std::max(largest, tet.id);
  const IdHomes homes(peers, largest);
  IdMail<TetRecord> mail(peers, homes);
  for (const TetRecord& tet : mine) mail.add(tet.id, tet);
  const auto from_each = mail.deliver();
  std::vector<std::pair<TetRecord, std::size_t>> all;
  for (std::size_t r = 0; r < from_each.size(); ++r)
    for (const TetRecord& tet : from_each[r]) all.emplace_back(tet, r);
  std::ranges::stable_sort(all, {}, [](const auto& tet) { return tet.first.id; });
  std::string issue;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (issue.empty() && i > 0 && all[i].first.id == all[i - 1].first.id)
      issue = text("rank ", all[i].second, ": tet id ", all[i].first.id, ": is on rank ", all[i - 1].second,
                   " too");
    slice.tets.push_back(all[i].first.vertices);
    slice.tet_refs.push_back(static_cast<std::int32_t>(all[i].first.ref));
  }
  partition::agree(peers, issue);
}

void number_tets(Peers& peers, const Part& part, const Mesh& mesh, const std::vector<std::uint64_t>& numbers,
                 MeshSlice& slice) {
  std::vector<TetRecord> mine;
  mine.reserve(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    TetRecord record{part.tet_ids.empty() ? t : part.tet_ids[t], {}, mesh.tet_refs[t]};
    for (std::size_t i = 0; i < 4; ++i)
      record.vertices[i] = static_cast<std::uint32_t>(numbers[mesh.tets[t][i]]);
    mine.push_back(record);
  }
  bool any = false, all = true;
  const char has_ids = mesh.tets.empty() ? 2 : part.tet_ids.empty() ? 0 : 1;
  for (const auto& of_rank : partition::allgather(peers, std::vector<char>{has_ids})) {
    any |= of_rank[0] == 1;
    all &= of_rank[0] != 0;
  }
  if (any != all && any) throw InputError("", "tet ids", "some ranks with tets give them, others do not");
  if (any) {
    order_tets(peers, mine, slice);
  } else {
    for (const TetRecord& tet : mine) {
      slice.tets.push_back(tet.vertices);
      slice.tet_refs.push_back(static_cast<std::int32_t>(tet.ref));
    }
  }
  const partition::Ranges ranges(peers, slice.tets.size());
  slice.num_tets = ranges.total();
  slice.first_tet = ranges.first(peers.rank());
  if (slice.num_tets == 0) throw InputError("", "", "has no tetrahedra");
}

constexpr std::uint8_t kKeptMark = 1, kRidgeMark = 2, kRequiredMark = 4;

/// A triangle or an edge of N vertices, its vertices ascending, on its way to the home of the lowest.
template <std::size_t N>
struct EntityRecord {
  std::array<std::uint32_t, N> vertices;
  std::uint32_t marks;
};

/// A record at its home: where it came from.
template <std::size_t N>
struct ArrivedEntity {
  EntityRecord<N> record;
  std::uint32_t rank, index;
};

/// All ranks: for each record that a rank has sent here, whether it is the first of the same vertices, with
/// the marks of all of them then.
template <std::size_t N>
std::vector<std::vector<std::uint8_t>> judged(const std::vector<std::vector<EntityRecord<N>>>& from_each) {
  std::vector<ArrivedEntity<N>> all;
  std::vector<std::vector<std::uint8_t>> answers(from_each.size());
  for (std::uint32_t r = 0; r < from_each.size(); ++r) {
    answers[r].resize(from_each[r].size(), 0);
    for (std::uint32_t i = 0; i < from_each[r].size(); ++i) all.push_back({from_each[r][i], r, i});
  }
  const auto vertices = [](const ArrivedEntity<N>& a) -> const auto& { return a.record.vertices; };
  std::ranges::stable_sort(all, {}, vertices);
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    std::uint32_t marks = kKeptMark;
    for (; end < all.size() && vertices(all[end]) == vertices(all[begin]); ++end)
      marks |= all[end].record.marks;
    answers[all[begin].rank][all[begin].index] = static_cast<std::uint8_t>(marks);
  }
  return answers;
}

/// All ranks: marks of this rank's entities, those of all that have the same vertices at the first of these
/// (which has kKeptMark), 0 at the others.
template <std::size_t N>
std::vector<std::uint8_t> agreed_marks(Peers& peers,
                                       const std::vector<std::array<std::uint32_t, N>>& entities,
                                       const std::vector<std::uint8_t>& marks) {
  std::vector<std::vector<EntityRecord<N>>> to_each(static_cast<std::size_t>(peers.ranks()));
  std::vector<std::uint32_t> homes;
  for (std::size_t e = 0; e < entities.size(); ++e) {
    EntityRecord<N> record{entities[e], marks[e]};
    std::ranges::sort(record.vertices);
    homes.push_back(record.vertices[0] % static_cast<std::uint32_t>(to_each.size()));
    to_each[homes.back()].push_back(record);
  }
  const auto answers = partition::all_to_all(peers, judged(partition::all_to_all(peers, std::move(to_each))));
  std::vector<std::size_t> next(answers.size(), 0);
  std::vector<std::uint8_t> agreed;
  for (const std::uint32_t home : homes) agreed.push_back(answers[home][next[home]++]);
  return agreed;
}

/// All ranks: the entities that this rank is the first to have, by numbers in the whole mesh, into
/// `vertices` and `refs`; returns their marks. Who lists one first fixes its place and orientation.
template <std::size_t N>
std::vector<std::uint8_t> take_entities(Peers& peers, std::vector<std::array<std::uint32_t, N>> entities,
                                        const std::vector<std::int32_t>& entity_refs,
                                        const std::vector<std::uint64_t>& numbers,
                                        const std::vector<std::uint8_t>& marks,
                                        std::vector<std::array<std::uint32_t, N>>& vertices,
                                        std::vector<std::int32_t>& refs) {
  for (auto& entity : entities)
    for (std::uint32_t& v : entity) v = static_cast<std::uint32_t>(numbers[v]);
  std::vector<std::uint8_t> kept;
  const std::vector<std::uint8_t> agreed = agreed_marks(peers, entities, marks);
  for (std::size_t e = 0; e < entities.size(); ++e) {
    if (agreed[e] == 0) continue;
    vertices.push_back(entities[e]);
    refs.push_back(entity_refs[e]);
    kept.push_back(agreed[e]);
  }
  return kept;
}

/// Numbers of those with the mark, counted from `first`.
std::vector<std::uint32_t> marked(const std::vector<std::uint8_t>& marks, std::uint8_t mark,
                                  std::uint64_t first) {
  std::vector<std::uint32_t> numbers;
  for (std::size_t e = 0; e < marks.size(); ++e)
    if (marks[e] & mark) numbers.push_back(static_cast<std::uint32_t>(first + e));
  return numbers;
}

/// All ranks: the vertices on these lists, each once, ascending.
std::vector<std::uint32_t> listed_vertices(Peers& peers, const partition::Ranges& points,
                                           const std::vector<std::uint32_t>& list,
                                           const std::vector<std::uint64_t>& numbers) {
  std::vector<std::uint32_t> mine;
  for (const std::uint32_t v : list) mine.push_back(static_cast<std::uint32_t>(numbers[v]));
  return partition::each_at_its_point(peers, points, mine);
}

/// All ranks: the slice's triangles and edges, each on one rank.
void take_boundary(Peers& peers, const Mesh& mesh, const std::vector<std::uint64_t>& numbers,
                   MeshSlice& slice) {
  Mesh& boundary = slice.boundary;
  std::vector<std::uint8_t> of_triangles(mesh.triangles.size(), 0), of_edges(mesh.edges.size(), 0);
  for (const std::uint32_t t : mesh.required_triangles) of_triangles[t] |= kRequiredMark;
  for (const std::uint32_t e : mesh.ridges) of_edges[e] |= kRidgeMark;
  for (const std::uint32_t e : mesh.required_edges) of_edges[e] |= kRequiredMark;
  of_triangles = take_entities(peers, mesh.triangles, mesh.triangle_refs, numbers, of_triangles,
                               boundary.triangles, boundary.triangle_refs);
  of_edges =
      take_entities(peers, mesh.edges, mesh.edge_refs, numbers, of_edges, boundary.edges, boundary.edge_refs);
  count_boundary(peers, slice);
  boundary.required_triangles = marked(of_triangles, kRequiredMark, slice.first_triangle);
  boundary.ridges = marked(of_edges, kRidgeMark, slice.first_edge);
  boundary.required_edges = marked(of_edges, kRequiredMark, slice.first_edge);
}

/// Records of vertices on a CAD model; of a shared vertex each rank may have them.
template <class Record>
std::vector<Record> numbered(std::vector<Record> records, const std::vector<std::uint64_t>& numbers) {
  for (Record& r : records) r.vertex = static_cast<std::uint32_t>(numbers[r.vertex]);
  return records;
}

/// A rank gives a metric where all do.
void agree_on_metric(Peers& peers, const Metric* metric) {
  const auto all = partition::allgather(peers, std::vector<char>{metric ? char{1} : char{0}});
  for (const auto& of_rank : all)
    if (of_rank[0] != all[0][0]) throw InputError("", "metric", "some ranks give one, others do not");
}

}  // namespace

MeshSlice slice_of_parts(Peers& peers, const Part& part, const Metric* metric) {
  agree_on_metric(peers, metric);
  agree_naming_rank(peers, [&] { check_part(part, metric); });
  const WholeMesh whole(part.mesh);
  MeshSlice slice;
  const std::vector<std::uint64_t> numbers = number_points(peers, part, *whole, metric, slice);
  check_faces_of_parts(peers, *whole, numbers);
  number_tets(peers, part, *whole, numbers, slice);
  take_boundary(peers, *whole, numbers, slice);
  const partition::Ranges points(peers, slice.points.size());
  slice.boundary.corners = listed_vertices(peers, points, part.mesh.corners, numbers);
  slice.boundary.required_points = listed_vertices(peers, points, part.mesh.required_points, numbers);
  slice.boundary.association.nodes = numbered(part.mesh.association.nodes, numbers);
  slice.boundary.association.edges = numbered(part.mesh.association.edges, numbers);
  slice.boundary.association.faces = numbered(part.mesh.association.faces, numbers);
  return slice;
}

}  // namespace weft::tools
