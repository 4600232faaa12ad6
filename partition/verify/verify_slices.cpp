// Tets meet at the ranks that have their points: there all tets around a vertex are, and so all that share a
// face.
#include "partition/verify/verify_slices.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "meshing/mesh/check_parts.h"
#include "meshing/mesh/check_steps.h"
#include "meshing/mesh/problems.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/slice/fetched_points.h"
#include "partition/verify/connected_sets.h"

namespace weft::partition {
namespace {

using meshing::CompensatedSum;
using meshing::MeshData;
using meshing::Point;
using meshing::Problems;
using namespace meshing::checks;

/// A tet on its way to those who have its points. Without padding.
struct StarTet {
  std::uint64_t number;
  std::array<std::uint32_t, 4> vertices;
  std::int32_t ref, sign;
};

/// A triangle or an edge on its way to those who have its vertices.
template <std::size_t N>
struct Listed {
  std::uint32_t number;
  std::array<std::uint32_t, N> vertices;
};
using ListedTriangle = Listed<3>;
using ListedEdge = Listed<2>;

class SlicesCheck {
 public:
  SlicesCheck(Peers& peers, const MeshSlice& slice, int max_problems)
      : peers_(peers),
        slice_(slice),
        points_(peers, slice.points.size()),
        limit_(static_cast<std::size_t>(std::max(max_problems, 0))),
        problems_(limit_) {}

  std::string array_problem() {
    check_the_arrays();
    std::vector<std::string> problems = problems_.take();
    return problems.empty() ? "" : std::move(problems.front());
  }

  meshing::CheckReport run() {
    check_the_arrays();
    meshing::CheckReport report;
    if (problems_.count() == 0) {
      const std::vector<std::int8_t> signs = check_tets(report);
      check_faces(signs, report);
      sum_triangles(report);
    }
    report.num_problems = problems_.count();
    report.problems = problems_.take();
    return report;
  }

 private:
  /// What the ranks have found, one after the other.
  void append(Problems&& mine) {
    const std::uint64_t count = mine.count();
    Bytes text;
    for (const std::string& sentence : mine.take()) {
      const auto* begin = reinterpret_cast<const std::byte*>(sentence.c_str());
      text.insert(text.end(), begin, begin + sentence.size() + 1);
    }
    const auto counts = partition::allgather(peers_, std::vector<std::uint64_t>{count});
    if (std::ranges::all_of(counts, [](const auto& c) { return c[0] == 0; })) return;
    const std::vector<Bytes> texts = peers_.allgather(std::move(text));
    for (std::size_t r = 0; r < counts.size(); ++r) {
      Problems of_rank(limit_);
      std::uint64_t added = 0;
      const auto* at = reinterpret_cast<const char*>(texts[r].data());
      for (const char* const end = at + texts[r].size(); at != end; at += std::string(at).size() + 1, ++added)
        of_rank.add(at);
      for (; added < counts[r][0]; ++added) of_rank.add("");  // behind the limit: only counted
      problems_.append(std::move(of_rank));
    }
  }

  /// In the order of meshing::check_arrays().
  void check_the_arrays() {
    const MeshData& b = slice_.boundary;
    const auto look = [&](const auto& check) {
      Problems found(limit_);
      check(found);
      append(std::move(found));
    };
    look([&](Problems& p) { check_coordinates(slice_.points, p, slice_.first_point); });
    look([&](Problems& p) { check_vertices("tet", slice_.tets, slice_.num_points, p, slice_.first_tet); });
    look([&](Problems& p) {
      check_vertices("triangle", b.triangles, slice_.num_points, p, slice_.first_triangle);
    });
    look([&](Problems& p) { check_vertices("edge", b.edges, slice_.num_points, p, slice_.first_edge); });
    const auto look_at = [&](const char* name, const std::vector<std::uint32_t>& list, std::uint64_t limit) {
      const std::uint64_t passed = Ranges(peers_, list.size()).first(peers_.rank());
      look([&](Problems& p) { check_list(name, list, limit, p, passed); });
    };
    look_at("corner", b.corners, slice_.num_points);
    look_at("required vertex", b.required_points, slice_.num_points);
    look_at("ridge", b.ridges, slice_.num_edges);
    look_at("required edge", b.required_edges, slice_.num_edges);
    look_at("required triangle", b.required_triangles, slice_.num_triangles);
  }

  /// Signs of the slice's tets, and volumes.
  std::vector<std::int8_t> check_tets(meshing::CheckReport& report) {
    const FetchedPoints points(peers_, slice_, points_, slice_.tets);
    std::vector<std::int8_t> signs(slice_.tets.size());
    Problems found(limit_);
    find_in_chunks(signs.size(), found, [&](std::size_t begin, std::size_t end, Problems& here) {
      for (std::size_t t = begin; t < end; ++t)
        signs[t] = check_orientation(slice_.first_tet + t, points.of(slice_.tets[t]), here);
    });
    append(std::move(found));
    put_volumes(sum_over_ranks(sum_by_ref(
                    slice_.tet_refs, [&](std::size_t t) { return volume_of(points.of(slice_.tets[t])); })),
                report);
    return signs;
  }

  /// Sums of all ranks, in their order.
  SumsByRef sum_over_ranks(const SumsByRef& mine) {
    struct Sum {
      std::int64_t ref;
      CompensatedSum sum;
    };
    std::vector<Sum> sums;
    for (const auto& [ref, sum] : mine) sums.push_back({ref, sum});
    SumsByRef all;
    for (const auto& of_rank : partition::allgather(peers_, sums))
      for (const Sum& s : of_rank) add(s.sum, all[static_cast<std::int32_t>(s.ref)]);
    return all;
  }

  /// All tets at the slice's points, by their numbers.
  std::vector<StarTet> stars(const std::vector<std::int8_t>& signs) {
    std::vector<std::vector<StarTet>> to_each(static_cast<std::size_t>(peers_.ranks()));
    for (std::size_t t = 0; t < slice_.tets.size(); ++t) {
      std::array<std::size_t, 4> owners;
      for (std::size_t i = 0; i < 4; ++i) {
        owners[i] = points_.rank_of(slice_.tets[t][i]);
        if (std::find(owners.begin(), owners.begin() + i, owners[i]) == owners.begin() + i)
          to_each[owners[i]].push_back({slice_.first_tet + t, slice_.tets[t], slice_.tet_refs[t], signs[t]});
      }
    }
    return all_to_all_joined(peers_, std::move(to_each));  // ascending, as slices are with the ranks
  }

  void check_faces(const std::vector<std::int8_t>& signs, meshing::CheckReport& report) {
    MeshData mesh;
    std::vector<std::int8_t> signs_here;
    std::vector<std::uint64_t> numbers;
    for (const StarTet& tet : stars(signs)) {
      mesh.tets.push_back(tet.vertices);
      mesh.tet_refs.push_back(tet.ref);
      signs_here.push_back(static_cast<std::int8_t>(tet.sign));
      numbers.push_back(tet.number);
    }
    const std::vector<ListedTriangle> triangles =
        sent_to_lower(slice_.boundary.triangles, slice_.first_triangle);
    for (const ListedTriangle& t : triangles) mesh.triangles.push_back(t.vertices);
    const auto first = static_cast<std::uint32_t>(slice_.first_point);
    meshing::StarsReport here = meshing::check_stars(
        {mesh, signs_here, numbers, first, first + static_cast<std::uint32_t>(slice_.points.size())}, limit_);
    append(std::move(here.problems));
    report_triangles(triangles, here.matched);
    report_edges(std::move(mesh));

    std::vector<std::array<std::uint64_t, 2>> joined;
    for (std::size_t t = 0; t < here.component.size(); ++t)
      if (here.component[t] != t) joined.push_back({numbers[here.component[t]], numbers[t]});
    report.num_components = count_connected_sets(peers_, slice_.tets.size(), std::move(joined));
    const auto sums = partition::sum(peers_, std::vector{here.touching_edges, here.balls, here.used});
    report.touching_edges = sums[0];
    report.touching_vertices = sums[1] - sums[2];
    report.unreferenced_points = slice_.num_points - sums[2];
  }

  /// Whether this rank has the point.
  bool is_here(std::uint32_t vertex) const {
    return vertex >= slice_.first_point && vertex - slice_.first_point < slice_.points.size();
  }

  /// All ranks: triangles or edges (of all ranks, of which `mine` begin with number `first`) at those who
  /// have the point of a vertex that is not the greatest: each side of a triangle is then where its lower
  /// vertex is. Ascending.
  template <std::size_t N>
  std::vector<Listed<N>> sent_to_lower(const std::vector<std::array<std::uint32_t, N>>& mine,
                                       std::uint64_t first) {
    std::vector<std::vector<Listed<N>>> to_each(static_cast<std::size_t>(peers_.ranks()));
    for (std::size_t e = 0; e < mine.size(); ++e) {
      std::array<std::uint32_t, N> sorted = mine[e];
      std::ranges::sort(sorted);
      std::size_t last = to_each.size();
      for (std::size_t i = 0; i + 1 < N; ++i)
        if (const std::size_t owner = points_.rank_of(sorted[i]); owner != std::exchange(last, owner))
          to_each[owner].push_back({static_cast<std::uint32_t>(first + e), mine[e]});
    }
    return all_to_all_joined(peers_, std::move(to_each));
  }

  /// All ranks: numbers go to those in whose range they are; report(number) of each, ascending.
  template <class Report>
  void report_in_order(const Ranges& ranges, const std::vector<std::uint32_t>& numbers,
                       const Report& report) {
    std::vector<std::uint32_t> mine;
    for (const auto& of_rank : sent_to_owners(peers_, ranges, numbers))
      mine.insert(mine.end(), of_rank.begin(), of_rank.end());
    std::ranges::sort(mine);
    Problems found(limit_);
    for (const std::uint32_t number : mine) report(number, found);
    append(std::move(found));
  }

  /// All ranks: a triangle is judged where its least vertex is.
  void report_triangles(const std::vector<ListedTriangle>& triangles,
                        const std::vector<std::uint8_t>& matched) {
    std::vector<std::uint32_t> unmatched;
    std::vector<meshing::Triangle> mine;
    std::vector<std::uint32_t> numbers;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (!is_here(std::ranges::min(triangles[i].vertices))) continue;
      if (!matched[i]) unmatched.push_back(triangles[i].number);
      mine.push_back(triangles[i].vertices);
      numbers.push_back(triangles[i].number);
    }
    report_in_order(Ranges(peers_, slice_.boundary.triangles.size()), unmatched, report_no_face);
    const auto sorted = meshing::checks::sorted_triangles(mine);  // equal ones by number
    Problems found(limit_);
    for (std::size_t i = 1; i < sorted.size(); ++i)
      if (sorted[i].same_face(sorted[i - 1]))
        report_repeated(numbers[sorted[i - 1].place()], numbers[sorted[i].place()], found);
    append(std::move(found));
  }

  /// All ranks. `mesh`: all tets and triangles at this rank's points.
  void report_edges(MeshData mesh) {
    const std::vector<ListedEdge> edges = sent_to_lower(slice_.boundary.edges, slice_.first_edge);
    for (const ListedEdge& edge : edges) mesh.edges.push_back(edge.vertices);
    EdgeCheck check(mesh);
    check.mark(mesh.tets);
    check.mark(mesh.triangles);
    std::vector<std::uint32_t> unmatched;
    for (std::size_t e = 0; e < edges.size(); ++e)
      if (!check.found()[e]) unmatched.push_back(edges[e].number);
    report_in_order(Ranges(peers_, slice_.boundary.edges.size()), unmatched, report_no_edge);
  }

  /// Each rank sums its share of the triangles.
  void sum_triangles(meshing::CheckReport& report) {
    const MeshData& b = slice_.boundary;
    const FetchedPoints points(peers_, slice_, points_, b.triangles);
    report.area_by_ref = meshing::checks::values_of(sum_over_ranks(
        sum_by_ref(b.triangle_refs, [&](std::size_t t) { return area_of(points.of(b.triangles[t])); })));
  }

  Peers& peers_;
  const MeshSlice& slice_;
  const Ranges points_;
  const std::size_t limit_;
  Problems problems_;
};

}  // namespace

std::string array_problem(Peers& peers, const MeshSlice& slice) {
  return SlicesCheck(peers, slice, 1).array_problem();
}

meshing::CheckReport verify_slices(Peers& peers, const MeshSlice& slice, int max_problems) {
  return SlicesCheck(peers, slice, max_problems).run();
}

}  // namespace weft::partition
