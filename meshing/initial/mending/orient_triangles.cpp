#include "meshing/initial/mending/orient_triangles.h"

#include <algorithm>

#include "meshing/base/box.h"
#include "meshing/base/number_sets.h"
#include "meshing/initial/grid/interrupted.h"
#include "meshing/initial/mending/winding_number.h"

namespace weft::meshing {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;
// Of its area, what the vectors of a sheet's triangles add up to: nothing when it is closed, a half for half
// a ball, a fifth for a box without a lid.
constexpr double kNearlyClosed = 0.4;
constexpr double kNearlyAll = 0.99;

class Orienting {
 public:
  Orienting(const std::vector<Point>& points, LooseTriangles& triangles, const std::atomic<bool>* interrupt)
      : points_(points), triangles_(triangles), turned_(triangles.size()), interrupt_(interrupt) {}

  std::vector<bool> run(std::span<const std::array<std::uint32_t, 2>> crossings) {
    list_neighbours();
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      if (sheet_of_[t] == kNone) spread(t);
    for (std::uint32_t s = 0; s < sheets_.size(); ++s) measure(s);
    group(crossings);
    for (auto& group : groups_) turn_shells(group);
    if (groups_.size() > 1) turn_enclosed();
    return std::move(turned_);
  }

 private:
  struct Sheet {
    std::vector<std::uint32_t> triangles;
    bool closed = false;  ///< or nearly
    bool inwards = false;
  };
  struct Group {
    std::vector<std::uint32_t> sheets;
    Box box;
  };

  void list_neighbours() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const Triangle& w = triangles_.corners[t];
        edges.emplace_back(edge_key(w[k], w[(k + 1) % 3]), t);
      }
    std::sort(edges.begin(), edges.end());
    neighbours_.resize(triangles_.size());
    sheet_of_.assign(triangles_.size(), kNone);
    for (std::size_t i = 0, j; i < edges.size(); i = j) {
      j = i + 1;
      while (j < edges.size() && edges[j].first == edges[i].first) ++j;
      if (j != i + 2) continue;
      neighbours_[edges[i].second].push_back(edges[i + 1].second);
      neighbours_[edges[i + 1].second].push_back(edges[i].second);
    }
  }

  void turn(std::uint32_t t) {
    std::swap(triangles_.corners[t][1], triangles_.corners[t][2]);
    turned_[t] = !turned_[t];
  }
  void turn_sheet(std::uint32_t s) {
    for (const std::uint32_t t : sheets_[s].triangles) turn(t);
  }

  /// Whether two neighbours run along their common edge in the same direction, which one of them should not.
  bool disagree(const Triangle& a, const Triangle& b) const {
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        if (a[i] == b[k] && a[(i + 1) % 3] == b[(k + 1) % 3]) return true;
    return false;
  }

  void spread(std::uint32_t first) {
    Sheet sheet;
    const auto number = static_cast<std::uint32_t>(sheets_.size());
    sheet.triangles = {first};
    sheet_of_[first] = number;
    double turned = 0, kept = 0;
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
      const std::uint32_t t = sheet.triangles[i];
      (turned_[t] ? turned : kept) += norm(area_vector(t));
      for (const std::uint32_t n : neighbours_[t]) {
        if (sheet_of_[n] != kNone) continue;
        sheet_of_[n] = number;
        if (disagree(triangles_.corners[t], triangles_.corners[n])) turn(n);
        sheet.triangles.push_back(n);
      }
    }
    sheets_.push_back(std::move(sheet));
    if (turned > kept) turn_sheet(number);
  }

  Vec area_vector(std::uint32_t t) const {
    const auto& [a, b, c] = triangles_.corners[t];
    return 0.5 * cross(points_[b] - points_[a], points_[c] - points_[a]);
  }
  Point middle(std::uint32_t t) const {
    const auto& [a, b, c] = triangles_.corners[t];
    return (1.0 / 3) * (points_[a] + points_[b] + points_[c]);
  }

  void measure(std::uint32_t s) {
    Sheet& sheet = sheets_[s];
    Vec sum;
    Point centre;
    double area = 0, volume = 0;
    for (const std::uint32_t t : sheet.triangles) {
      const double size = norm(area_vector(t));
      sum += area_vector(t);
      centre += size * middle(t);
      area += size;
    }
    if (area > 0) centre = (1 / area) * centre;
    for (const std::uint32_t t : sheet.triangles) volume += dot(middle(t) - centre, area_vector(t));
    sheet.closed = norm(sum) < kNearlyClosed * area;
    sheet.inwards = volume < 0;
  }

  void group(std::span<const std::array<std::uint32_t, 2>> crossings) {
    NumberSets sets(sheets_.size());
    std::vector<std::uint32_t> at_vertex(points_.size(), kNone);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (const std::uint32_t v : triangles_.corners[t]) {
        if (at_vertex[v] == kNone) at_vertex[v] = sheet_of_[t];
        sets.unite(at_vertex[v], sheet_of_[t]);
      }
    for (const auto& [s, t] : crossings) sets.unite(sheet_of_[s], sheet_of_[t]);
    std::vector<std::uint32_t> number(sheets_.size(), kNone);
    for (std::uint32_t s = 0; s < sheets_.size(); ++s) {
      const std::uint32_t r = sets.of(s);
      if (number[r] == kNone) {
        number[r] = static_cast<std::uint32_t>(groups_.size());
        groups_.emplace_back();
      }
      Group& group = groups_[number[r]];
      group.sheets.push_back(s);
      for (const std::uint32_t t : sheets_[s].triangles)
        for (const std::uint32_t v : triangles_.corners[t]) group.box.include(points_[v]);
    }
  }

  /// Some sheets as a surface of their own.
  struct Part {
    std::vector<Triangle> triangles;
    std::vector<std::int32_t> counts;
  };
  Part part_of(const std::vector<std::uint32_t>& sheets) const {
    Part part;
    for (const std::uint32_t s : sheets)
      for (const std::uint32_t t : sheets_[s].triangles) {
        part.triangles.push_back(triangles_.corners[t]);
        part.counts.push_back(triangles_.sheets[t]);
      }
    return part;
  }

  void turn_shells(const Group& group) {
    std::vector<std::uint32_t> closed, holes;
    bool turned = false;
    for (const std::uint32_t s : group.sheets) {
      if (!sheets_[s].closed) continue;
      closed.push_back(s);
      if (!sheets_[s].inwards) continue;
      turn_sheet(s);
      turned = true;
    }
    if (!turned || closed.size() == 1) return;
    const Part part = part_of(closed);
    const WindingNumber winding(points_, part.triangles, part.counts);
    std::uint32_t first = 0;
    for (const std::uint32_t s : closed) {
      if (sheets_[s].inwards && is_within_others(s, winding, first)) holes.push_back(s);
      first += static_cast<std::uint32_t>(sheets_[s].triangles.size());
    }
    for (const std::uint32_t s : holes) turn_sheet(s);
  }

  /// What the others go around is what all do (the sheet's triangles from `first` on there), less the sheet.
  bool is_within_others(std::uint32_t s, const WindingNumber& all, std::uint32_t first) const {
    check_interrupt(interrupt_);
    const Part part = part_of({s});
    const WindingNumber own(points_, part.triangles, part.counts);
    double area = 0, within = 0;
    for (std::uint32_t i = 0; i < part.triangles.size(); ++i) {
      const std::uint32_t t = sheets_[s].triangles[i];
      const double size = norm(area_vector(t));
      area += size;
      if (all.at(middle(t), first + i) - own.at(middle(t), i) > 0.5) within += size;
    }
    return within > kNearlyAll * area;
  }

  void turn_enclosed() {
    std::vector<int> depth(groups_.size(), 0);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      check_interrupt(interrupt_);
      const Part part = part_of(groups_[g].sheets);
      const WindingNumber winding(points_, part.triangles, part.counts);
      for (std::size_t other = 0; other < groups_.size(); ++other) {
        const std::uint32_t t = sheets_[groups_[other].sheets[0]].triangles[0];
        const Point& p = points_[triangles_.corners[t][0]];
        if (other == g || groups_[g].box.distance2(p) > 0) continue;
        depth[other] += winding.at(p) > 0.5;
      }
    }
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (depth[g] % 2 == 1)
        for (const std::uint32_t s : groups_[g].sheets)
          if (sheets_[s].closed) turn_sheet(s);
  }

  const std::vector<Point>& points_;
  LooseTriangles& triangles_;
  std::vector<bool> turned_;
  const std::atomic<bool>* interrupt_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<std::uint32_t> sheet_of_;
  std::vector<Sheet> sheets_;
  std::vector<Group> groups_;
};

}  // namespace

std::vector<bool> orient_triangles(const std::vector<Point>& points, LooseTriangles& triangles,
                                   std::span<const std::array<std::uint32_t, 2>> crossings,
                                   const std::atomic<bool>* interrupt) {
  return Orienting(points, triangles, interrupt).run(crossings);
}

}  // namespace weft::meshing
