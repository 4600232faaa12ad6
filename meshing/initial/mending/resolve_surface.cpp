// Clean, turn, cut, choose, close: each step of it is a file of this folder.
#include "meshing/initial/mending/resolve_surface.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

#include "meshing/base/box.h"
#include "meshing/base/error.h"
#include "meshing/base/number_sets.h"
#include "meshing/initial/clean_triangles.h"
#include "meshing/initial/grid/interrupted.h"
#include "meshing/initial/mending/close_openings.h"
#include "meshing/initial/mending/listed_edges.h"
#include "meshing/initial/mending/orient_triangles.h"
#include "meshing/initial/mending/split_crossings.h"
#include "meshing/initial/mending/surface_distance.h"
#include "meshing/initial/mending/winding_number.h"
#include "meshing/initial/self_intersections.h"

namespace weft::meshing {
namespace {

using Pair = std::array<std::uint32_t, 2>;

constexpr double kSame = 1e-9;                    // of the diagonal, as in close_surface()
constexpr std::size_t kMostPairs = 2000000;       // of crossing triangles: beyond, something else is wrong
constexpr int kMostCuts = 12;                     // rounded pieces cross anew, seldom and by little
constexpr double kNearEdges = 0.1, kNear = 1e-3;  // of the shortest edge of a cut triangle; of the diagonal
// Of the area: half a ball would take half to be closed, a box without a lid a fifth.
constexpr double kMostClosing = 1.0 / 3, kMostLost = 0.25;

class Resolution {
 public:
  Resolution(MeshData& surface, std::vector<std::uint32_t>& source, std::vector<MeshMend>& mends,
             const std::atomic<bool>* interrupt)
      : surface_(surface),
        source_(source),
        mends_(mends),
        points_(surface.points),
        edges_(surface),
        interrupt_(interrupt) {
    Box box;
    for (const Triangle& t : surface.triangles)
      for (const std::uint32_t v : t) box.include(surface.points[v]);
    diagonal_ = norm(box.size());
    tolerance_ = kSame * diagonal_;
    loose_.corners = surface.triangles;
    loose_.refs = surface.triangle_refs;
    loose_.sheets.assign(loose_.size(), 1);
    loose_.source.resize(loose_.size());
    std::iota(loose_.source.begin(), loose_.source.end(), 0u);
  }

  /// Why nothing was done, if something should have been.
  std::string run() {
    clean();
    std::vector<Pair> pairs = crossings();
    if ((pairs.empty() && !is_open()) || loose_.size() == 0) return {};
    turn(pairs);
    if (!cut(std::move(pairs), true)) return left_;
    choose();
    if (loose_.size() == 0) return "no triangle bounds a volume";
    if (is_open() && !close()) return left_;
    const double lost = lost_area_ / (area(loose_) + lost_area_);
    if (lost > kMostLost) return fmt::format("{:.0f} % of the surface bounds no volume", 100 * lost);
    keep();
    return {};
  }

 private:
  // --- Steps

  void clean() {
    check_interrupt(interrupt_);
    TriangleCleaning cleaning(points_, loose_, tolerance_);
    cleaning.merge_points();
    cleaning.drop_collapsed();
    cleaning.mend_degenerate();
    cleaning.drop_collapsed();
    cleaning.merge_repeated();
    edges_.renumber(cleaning.merged());
    EdgeCuts cuts;
    for (const auto& [edge, vertex] : cleaning.splits()) cuts[edge] = {vertex};
    while (edges_.cut(cuts)) continue;  // ends, because pieces are shorter
  }

  std::vector<Pair> crossings() const {
    return self_intersections(points_, loose_.corners, kMostPairs + 1, interrupt_);
  }

  void turn(const std::vector<Pair>& pairs) {
    const std::vector<bool> turned = orient_triangles(points_, loose_, pairs, interrupt_);
    MeshMend mend{"triangles turned to agree with those beside them", "triangle", 0, {}, 0, ""};
    for (std::size_t t = 0; t < turned.size(); ++t)
      if (turned[t]) mend.add(source_[loose_.source[t]]);
    note(std::move(mend));
  }

  /// False if that does not end. `coarsen`: mends the needles that are made.
  bool cut(std::vector<Pair> pairs, bool coarsen) {
    MeshMend crossed{"triangles that crossed others cut along the crossing", "triangle", 0, {}, 0, ""};
    std::set<std::uint32_t> numbers;
    const std::size_t before = points_.size();
    for (int round = 0; !pairs.empty(); ++round) {
      if (round == kMostCuts || pairs.size() > kMostPairs) {
        left_ = fmt::format("cutting the triangles that cross does not end: {} pairs are left", pairs.size());
        return false;
      }
      for (const auto& [s, t] : pairs)
        for (const std::uint32_t i : {s, t}) numbers.insert(source_[loose_.source[i]]);
      split(pairs);
      clean();
      pairs = crossings();
      if (!pairs.empty() || !coarsen) continue;
      coarsen = false;
      mend_needles(before);
      clean();
      pairs = crossings();
    }
    for (const std::uint32_t n : numbers) crossed.add(n);
    note(std::move(crossed));
    MeshMend made{"vertices made where triangles crossed", "vertex", points_.size() - before, {}, 0, ""};
    note(std::move(made));
    return true;
  }

  /// New vertices near others become one with them, as if the triangles had met there; what crosses anew is
  /// cut again.
  void mend_needles(std::size_t first_new) {
    MeshMend moved{"vertices of crossings moved to what is near", "triangle", 0, {}, 0, "distance"};
    std::vector<double> limit(points_.size(), kNear * diagonal_);
    const auto limit_of = [&](std::uint32_t source) {
      const auto& [a, b, c] = surface_.triangles[source];
      const auto& p = surface_.points;
      return std::min(kNear * diagonal_,
                      kNearEdges * std::min({norm(p[a] - p[b]), norm(p[b] - p[c]), norm(p[c] - p[a])}));
    };
    for (std::size_t t = 0; t < loose_.size(); ++t)
      for (const std::uint32_t v : loose_.corners[t])
        limit[v] = std::min(limit[v], limit_of(loose_.source[t]));
    constexpr int kMostRounds = 3;
    for (int round = 0; round < kMostRounds; ++round)
      if (!contract(first_new, limit, moved)) break;
    note(std::move(moved));
  }

  /// Short edges, the shortest first, of which the later vertex is new. Each vertex takes part once.
  bool contract(std::size_t first_new, const std::vector<double>& limit, MeshMend& moved) {
    std::vector<std::tuple<double, std::uint32_t, std::uint32_t, std::uint32_t>> edges;
    for (std::uint32_t t = 0; t < loose_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(loose_.corners[t][k], loose_.corners[t][(k + 1) % 3]);
        const double length = norm(points_[a] - points_[b]);
        if (b >= first_new && length < limit[b]) edges.emplace_back(length, a, b, t);
      }
    std::sort(edges.begin(), edges.end());
    std::vector<std::uint32_t> now(points_.size());
    std::iota(now.begin(), now.end(), 0u);
    std::vector<bool> used(points_.size());
    for (const auto& [length, a, b, t] : edges) {
      if (used[a] || used[b]) continue;
      used[a] = used[b] = true;
      now[b] = a;
      moved.add(source_[loose_.source[t]], length);
    }
    for (Triangle& t : loose_.corners)
      for (std::uint32_t& v : t) v = now[v];
    edges_.renumber(now);
    TriangleCleaning(points_, loose_, tolerance_).drop_collapsed();
    return !edges.empty();
  }

  void split(const std::vector<Pair>& pairs) {
    SplitTriangles pieces = split_crossings(points_, loose_.corners, pairs, interrupt_);
    LooseTriangles result;
    for (std::size_t i = 0; i < pieces.triangles.size(); ++i) {
      const std::uint32_t parent = pieces.parent[i];
      result.corners.push_back(pieces.triangles[i]);
      result.refs.push_back(loose_.refs[parent]);
      result.source.push_back(loose_.source[parent]);
      result.sheets.push_back(loose_.sheets[parent]);
    }
    points_ = std::move(pieces.points);
    loose_ = std::move(result);
    edges_.cut(pieces.cuts);
  }

  /// Patches end where not two triangles meet at an edge. A patch stays if one of its sides is inside and the
  /// other is not.
  void choose() {
    const std::vector<double> winding = winding_numbers();
    std::uint32_t count = 0;
    const std::vector<std::uint32_t> patch = patches(count);
    std::vector<double> mean(count, 0), area(count, 0);
    std::vector<bool> open(count);
    for (std::size_t t = 0; t < loose_.size(); ++t) {
      mean[patch[t]] += area_of(loose_.corners[t]) * winding[t];
      area[patch[t]] += area_of(loose_.corners[t]);
      open[patch[t]] = open[patch[t]] || has_free_edge_[t];
    }
    for (std::size_t p = 0; p < count; ++p) mean[p] = area[p] > 0 ? mean[p] / area[p] : 0;
    std::vector<bool> drop(loose_.size());
    MeshMend inner{"triangles inside the volume removed", "triangle", 0, {}, 0, ""};
    for (std::uint32_t t = 0; t < loose_.size(); ++t) {
      const double middle = mean[patch[t]], half = 0.5 * loose_.sheets[t];
      const double back = middle + half, front = middle - half;
      // A patch of one sheet with a free edge at a volume's border has about 1/2, one that hangs in it 1, one
      // outside 0; where several sheets lie upon each other they have as many times that.
      const bool hangs = open[patch[t]] && std::abs(middle - std::abs(half)) > 0.5 * std::abs(half);
      drop[t] = hangs || (back > 0.5) == (front > 0.5);
      if (!drop[t] && front > 0.5) std::swap(loose_.corners[t][1], loose_.corners[t][2]);
      if (drop[t] && middle > 0.5)
        inner.add(source_[loose_.source[t]]);
      else if (drop[t] && half != 0)
        lose(t);
    }
    note(std::move(inner));
    loose_.erase(drop);
    loose_.sheets.assign(loose_.size(), 1);
  }

  std::vector<double> winding_numbers() const {
    const WindingNumber winding(points_, loose_.corners, loose_.sheets);
    std::vector<double> values(loose_.size());
    tbb::parallel_for(0u, static_cast<std::uint32_t>(loose_.size()), [&](std::uint32_t t) {
      check_interrupt(interrupt_);
      const auto& [a, b, c] = loose_.corners[t];
      values[t] = winding.at((1.0 / 3) * (points_[a] + points_[b] + points_[c]), t);
    });
    return values;
  }

  std::vector<std::uint32_t> patches(std::uint32_t& count) {
    NumberSets sets(loose_.size());
    has_free_edge_.assign(loose_.size(), false);
    for_each_edge([&](std::span<const std::uint32_t> around) {
      if (around.size() == 1) has_free_edge_[around[0]] = true;
      if (around.size() != 2 || loose_.sheets[around[0]] != loose_.sheets[around[1]]) return true;
      sets.unite(around[0], around[1]);
      return true;
    });
    std::vector<std::uint32_t> number(loose_.size(), TriangleCleaning::kUnused), patch(loose_.size());
    count = 0;
    for (std::uint32_t t = 0; t < loose_.size(); ++t) {
      std::uint32_t& n = number[sets.of(t)];
      if (n == TriangleCleaning::kUnused) n = count++;
      patch[t] = n;
    }
    return patch;
  }

  bool close() {
    ClosedOpenings closed;
    try {
      closed = close_openings(points_, loose_, input_numbers(), interrupt_);
    } catch (const InputError& error) {
      left_ = fmt::format("no tets between the borders of its openings: {}", error.what());
      return false;
    }
    const LooseTriangles before = std::move(loose_);
    points_ = std::move(closed.points);
    loose_ = std::move(closed.triangles);
    edges_.cut(closed.cuts);
    double fresh = 0, kept = 0;
    for (std::size_t t = 0; t < loose_.size(); ++t)
      (closed.closing[t] ? fresh : kept) += area_of(loose_.corners[t]);
    if (!(fresh <= kMostClosing * kept)) {
      left_ = kept > 0
                  ? fmt::format("closing its openings would take {:.0f} % of its area", 100 * fresh / kept)
                  : "it goes around no volume";
      return false;
    }
    lost_area_ += std::max(0.0, area(before) - kept);
    const SurfaceDistance distance(surface_.points, surface_.triangles);
    MeshMend mend{"triangles made across openings", "triangle beside", 0, {}, 0, "distance"};
    for (std::size_t t = 0; t < loose_.size(); ++t)
      if (closed.closing[t]) mend.add(source_[loose_.source[t]], distance.from(places(loose_.corners[t])));
    note(std::move(mend));
    clean();
    std::vector<Pair> pairs = crossings();
    if (!pairs.empty() && !cut(std::move(pairs), false)) return false;
    if (is_open()) left_ = "it is still open";
    return left_.empty();
  }

  /// Triangle t bounds nothing.
  void lose(std::uint32_t t) {
    lost_area_ += area_of(loose_.corners[t]);
    lost_.push_back(places(loose_.corners[t]));
    lost_source_.push_back(source_[loose_.source[t]]);
  }

  void keep() {
    const SurfaceDistance distance(points_, loose_.corners);
    MeshMend lost{"triangles that bound no volume removed", "triangle", 0, {}, 0, "distance"};
    for (std::size_t i = 0; i < lost_.size(); ++i) lost.add(lost_source_[i], distance.from(lost_[i]));
    note(std::move(lost));
    source_ = input_numbers();
    surface_.points = std::move(points_);
    surface_.point_refs.resize(surface_.points.size(), 0);
    surface_.triangles = std::move(loose_.corners);
    surface_.triangle_refs = std::move(loose_.refs);
    edges_.give_to(surface_);
    mends_.insert(mends_.end(), fresh_mends_.begin(), fresh_mends_.end());
  }

  // --- Helpers

  /// Of each triangle: its number in the input.
  std::vector<std::uint32_t> input_numbers() const {
    std::vector<std::uint32_t> numbers;
    for (const std::uint32_t s : loose_.source) numbers.push_back(source_[s]);
    return numbers;
  }

  void note(MeshMend mend) {
    if (mend.count > 0) fresh_mends_.push_back(std::move(mend));
  }

  std::array<Point, 3> places(const Triangle& t) const {
    return {points_[t[0]], points_[t[1]], points_[t[2]]};
  }
  double area_of(const Triangle& t) const {
    return 0.5 * norm(cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]));
  }
  double area(const LooseTriangles& triangles) const {
    double sum = 0;
    for (const Triangle& t : triangles.corners) sum += area_of(t);
    return sum;
  }

  /// Visits the triangles at each edge until `visit` says false.
  template <class Visit>
  void for_each_edge(const Visit& visit) const {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;
    edges.reserve(3 * loose_.size());
    for (std::uint32_t t = 0; t < loose_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k)
        edges.emplace_back(edge_key(loose_.corners[t][k], loose_.corners[t][(k + 1) % 3]), t);
    std::sort(edges.begin(), edges.end());
    std::vector<std::uint32_t> around;
    for (std::size_t i = 0; i < edges.size();) {
      around.clear();
      const std::uint64_t key = edges[i].first;
      for (; i < edges.size() && edges[i].first == key; ++i) around.push_back(edges[i].second);
      if (!visit(std::span<const std::uint32_t>(around))) return;
    }
  }

  bool is_open() const {
    bool open = false;
    for_each_edge([&](std::span<const std::uint32_t> around) {
      open = around.size() == 1;
      return !open;
    });
    return open;
  }

  MeshData& surface_;
  std::vector<std::uint32_t>& source_;
  std::vector<MeshMend>& mends_;
  std::vector<Point> points_;
  ListedEdges edges_;
  double diagonal_ = 0, tolerance_ = 0;
  std::string left_;
  LooseTriangles loose_;
  std::vector<bool> has_free_edge_;
  double lost_area_ = 0;
  std::vector<std::array<Point, 3>> lost_;
  std::vector<std::uint32_t> lost_source_;
  std::vector<MeshMend> fresh_mends_;
  const std::atomic<bool>* interrupt_;
};

}  // namespace

std::string resolve_surface(MeshData& surface, std::vector<std::uint32_t>& source,
                            std::vector<MeshMend>& mends, const std::atomic<bool>* interrupt) {
  return surface.triangles.empty() ? std::string() : Resolution(surface, source, mends, interrupt).run();
}

}  // namespace weft::meshing
