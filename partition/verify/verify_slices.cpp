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
#include "partition/distribute/fetched_points.h"
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
  bool is_first() const { return peers_.rank() == 0; }

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
    Problems of_points(limit_), of_tets(limit_), of_rest(limit_);
    const MeshData& b = slice_.boundary;
    check_coordinates(slice_.points, of_points, slice_.first_point);
    check_vertices("tet", slice_.tets, slice_.num_points, of_tets, slice_.first_tet);
    if (is_first()) {
      check_vertices("triangle", b.triangles, slice_.num_points, of_rest);
      check_vertices("edge", b.edges, slice_.num_points, of_rest);
      check_list("corner", b.corners, slice_.num_points, of_rest);
      check_list("required vertex", b.required_points, slice_.num_points, of_rest);
      check_list("ridge", b.ridges, b.edges.size(), of_rest);
      check_list("required edge", b.required_edges, b.edges.size(), of_rest);
      check_list("required triangle", b.required_triangles, b.triangles.size(), of_rest);
    }
    append(std::move(of_points));
    append(std::move(of_tets));
    append(std::move(of_rest));
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
    mesh.triangles = slice_.boundary.triangles;
    const auto first = static_cast<std::uint32_t>(slice_.first_point);
    meshing::StarsReport here = meshing::check_stars(
        {mesh, signs_here, numbers, first, first + static_cast<std::uint32_t>(slice_.points.size())}, limit_);
    mesh = {};
    append(std::move(here.problems));
    const std::vector<std::uint8_t> matched = partition::max(peers_, here.matched);
    const std::vector<std::uint8_t> found =
        partition::max(peers_, meshing::find_edges(slice_.boundary, slice_.tets, is_first()));
    Problems unmatched(limit_);
    if (is_first()) meshing::report_unmatched(slice_.boundary, matched, found, unmatched);
    append(std::move(unmatched));

    std::vector<std::array<std::uint64_t, 2>> joined;
    for (std::size_t t = 0; t < here.component.size(); ++t)
      if (here.component[t] != t) joined.push_back({numbers[here.component[t]], numbers[t]});
    report.num_components = count_connected_sets(peers_, slice_.tets.size(), std::move(joined));
    const auto sums = partition::sum(peers_, std::vector{here.touching_edges, here.balls, here.used});
    report.touching_edges = sums[0];
    report.touching_vertices = sums[1] - sums[2];
    report.unreferenced_points = slice_.num_points - sums[2];
  }

  /// Each rank sums a share of the triangles, of which all have all.
  void sum_triangles(meshing::CheckReport& report) {
    const MeshData& b = slice_.boundary;
    const auto begin_of = [&](int rank) {
      return static_cast<std::ptrdiff_t>(b.triangles.size() * static_cast<std::size_t>(rank) /
                                         static_cast<std::size_t>(peers_.ranks()));
    };
    const std::vector<Triangle> triangles(b.triangles.begin() + begin_of(peers_.rank()),
                                          b.triangles.begin() + begin_of(peers_.rank() + 1));
    const std::vector<std::int32_t> refs(b.triangle_refs.begin() + begin_of(peers_.rank()),
                                         b.triangle_refs.begin() + begin_of(peers_.rank() + 1));
    const FetchedPoints points(peers_, slice_, points_, triangles);
    report.area_by_ref = meshing::checks::values_of(
        sum_over_ranks(sum_by_ref(refs, [&](std::size_t t) { return area_of(points.of(triangles[t])); })));
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
