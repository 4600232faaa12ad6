// Samples of each entity, and the ends of borders.
#include "meshing/cad/check_model.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "meshing/base/box.h"

namespace weft::meshing {
namespace {

// Readers give an entity without bounds parameters of 2e100, and points as far away.
constexpr double kNowhere = 1e50;
// Of the model's size: gaps and tolerances. 82 sound models have no gap beyond the first; their tolerances
// are at most 1e-4 of it.
constexpr double kSlight = 1e-5, kFatal = 1e-2;
// What OpenCASCADE knows any entity to, however small the model is: 1e-7, and what other programs make of it.
constexpr double kUsual = 1e-6;
// Of the size of all edges: a face that leaves its borders so far is not within them.
constexpr double kFarOut = 100;
constexpr int kSamples = 8;

bool is_near(double x) { return std::abs(x) < kNowhere; }
bool is_near(const Point& p) { return is_near(p.x) && is_near(p.y) && is_near(p.z); }

std::string number(double x) {
  std::array<char, 32> text{};
  constexpr auto kShortest = std::chars_format::general;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x, kShortest, 3).ptr};
}

std::string name(const char* kind, std::size_t index) {
  return std::string(kind) + " " + std::to_string(index + 1);
}

double at_share(double a, double b, int i) { return i == kSamples ? b : a + (b - a) * i / kSamples; }

class Checker {
 public:
  explicit Checker(const GeometryModel& model) : model_(model) {}

  ModelDefects run() {
    check_finite();
    if (!defects_.fatal.empty()) return std::move(defects_);
    size_ = norm(box_.size());
    check_sizes();
    check_tolerances();
    check_ends();
    check_borders();
    return std::move(defects_);
  }

 private:
  void check_finite();
  void check_finite_edges();
  void check_finite_faces();
  void find_used();
  Box box_of_face(std::size_t f) const;
  void check_sizes();
  void check_tolerances();
  void check_tolerance(const std::string& entity, double tolerance);
  void check_ends();
  void check_borders();
  double distance_from_face(std::size_t f, const EdgeUse& use) const;
  bool is_closed(std::size_t f) const;
  void judge_gap(double gap, double tolerance, const std::string& what);
  void fatal(std::string text) { defects_.fatal.push_back(std::move(text)); }

  const GeometryModel& model_;
  ModelDefects defects_;
  std::vector<bool> used_, used_nodes_;  // edges, nodes: those of borders
  Box box_;                              // of these, of faces without any
  double size_ = 0;
};

/// What is beside the body, such as sketches and axes, does not tell how large it is.
void Checker::find_used() {
  used_.assign(model_.edges().size(), false);
  used_nodes_.assign(model_.nodes().size(), false);
  for (const ModelFace& face : model_.faces())
    for (const EdgeUse& use : face.border) {
      used_[use.edge] = true;
      for (const std::uint32_t n : model_.edges()[use.edge].nodes)
        if (n != kNoEntity) used_nodes_[n] = true;
    }
}

void Checker::check_finite() {
  find_used();
  for (std::size_t n = 0; n < model_.nodes().size(); ++n)
    if (!is_near(model_.nodes()[n].x))
      fatal(name("node", n) + " is nowhere");
    else if (used_nodes_[n])
      box_.include(model_.nodes()[n].x);
  check_finite_edges();
  check_finite_faces();
}

void Checker::check_finite_edges() {
  for (std::size_t i = 0; i < model_.edges().size(); ++i) {
    const ModelEdge& e = model_.edges()[i];
    if (!is_near(e.begin) || !is_near(e.end) || !(e.begin < e.end)) {
      fatal(name("edge", i) + " has no ends: its parameter goes from " + number(e.begin) + " to " +
            number(e.end));
      continue;
    }
    for (int k = 0; k <= kSamples && !e.degenerate; ++k) {
      const Point x = model_.curve(static_cast<std::uint32_t>(i), at_share(e.begin, e.end, k)).x;
      if (!is_near(x)) {
        fatal(name("edge", i) + " is nowhere");
        break;
      }
      if (used_[i]) box_.include(x);
    }
  }
}

Box Checker::box_of_face(std::size_t f) const {
  const ModelFace& face = model_.faces()[f];
  Box box;
  for (int i = 0; i <= kSamples; ++i)
    for (int j = 0; j <= kSamples; ++j)
      box.include(model_
                      .surface(static_cast<std::uint32_t>(f),
                               {at_share(face.lo[0], face.hi[0], i), at_share(face.lo[1], face.hi[1], j)})
                      .x);
  return box;
}

void Checker::check_finite_faces() {
  for (std::size_t i = 0; i < model_.faces().size(); ++i) {
    const ModelFace& f = model_.faces()[i];
    bool ranges = true;
    for (std::size_t k = 0; k < 2; ++k)
      ranges = ranges && is_near(f.lo[k]) && is_near(f.hi[k]) && f.lo[k] < f.hi[k];
    if (!ranges) {
      fatal(name("face", i) + " is not bounded: its parameters go from (" + number(f.lo[0]) + ", " +
            number(f.lo[1]) + ") to (" + number(f.hi[0]) + ", " + number(f.hi[1]) + ")");
      continue;
    }
    const Box box = box_of_face(i);
    if (!is_near(box.lo) || !is_near(box.hi))
      fatal(name("face", i) + " is nowhere");
    else if (f.border.empty())
      box_.include(box.lo), box_.include(box.hi);
  }
}

void Checker::check_sizes() {
  for (std::size_t f = 0; f < model_.faces().size(); ++f)
    if (const double size = norm(box_of_face(f).size()); size > kFarOut * size_)
      fatal(name("face", f) + " is of size " + number(size) + ", all edges and nodes are within " +
            number(size_));
}

void Checker::check_tolerance(const std::string& entity, double tolerance) {
  if (!(tolerance <= std::max(kFatal * size_, kUsual)))
    fatal(entity + " is known to " + number(tolerance) + " only, where the model's size is " + number(size_));
}

void Checker::check_tolerances() {
  for (std::size_t i = 0; i < model_.nodes().size(); ++i)
    check_tolerance(name("node", i), model_.nodes()[i].tolerance);
  for (std::size_t i = 0; i < model_.edges().size(); ++i)
    check_tolerance(name("edge", i), model_.edges()[i].tolerance);
  for (std::size_t i = 0; i < model_.faces().size(); ++i)
    check_tolerance(name("face", i), model_.faces()[i].tolerance);
}

void Checker::judge_gap(double gap, double tolerance, const std::string& what) {
  if (!(gap <= kFatal * size_))
    fatal(what + " by " + number(gap) + ", where the model's size is " + number(size_));
  else if (gap > std::max(2 * tolerance, kSlight * size_))
    defects_.slight.push_back(what + " by " + number(gap));
}

void Checker::check_ends() {
  for (std::size_t i = 0; i < model_.edges().size(); ++i) {
    const ModelEdge& e = model_.edges()[i];
    if (e.degenerate) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      if (e.nodes[k] == kNoEntity) continue;
      const ModelNode& node = model_.nodes()[e.nodes[k]];
      const double gap =
          norm(model_.curve(static_cast<std::uint32_t>(i), k == 0 ? e.begin : e.end).x - node.x);
      judge_gap(gap, std::max(node.tolerance, e.tolerance),
                name("edge", i) + " does not end at its " + name("node", e.nodes[k]) + ":");
    }
  }
}

double Checker::distance_from_face(std::size_t f, const EdgeUse& use) const {
  const ModelEdge& e = model_.edges()[use.edge];
  const auto face = static_cast<std::uint32_t>(f);
  double largest = 0;
  for (int i = 0; i <= kSamples; ++i) {
    const double t = at_share(e.begin, e.end, i);
    if (e.degenerate && e.nodes[0] == kNoEntity) continue;
    const Point x = e.degenerate ? model_.nodes()[e.nodes[0]].x : model_.curve(use.edge, t).x;
    const double d = norm(model_.surface(face, model_.on_face(face, use, t)).x - x);
    if (!(d <= largest)) largest = d;
  }
  return largest;
}

/// Whether as many edges of the border begin at each node as end there.
bool Checker::is_closed(std::size_t f) const {
  std::vector<std::uint32_t> begins, ends;
  for (const EdgeUse& use : model_.faces()[f].border) {
    const auto& nodes = model_.edges()[use.edge].nodes;
    if (nodes[0] == nodes[1]) continue;
    begins.push_back(nodes[use.reversed]);
    ends.push_back(nodes[!use.reversed]);
  }
  std::ranges::sort(begins);
  std::ranges::sort(ends);
  return begins == ends;
}

void Checker::check_borders() {
  for (std::size_t f = 0; f < model_.faces().size(); ++f) {
    const ModelFace& face = model_.faces()[f];
    for (const EdgeUse& use : face.border) {
      const ModelEdge& e = model_.edges()[use.edge];
      const double of_node =
          e.degenerate && e.nodes[0] != kNoEntity ? model_.nodes()[e.nodes[0]].tolerance : 0;
      judge_gap(distance_from_face(f, use), std::max({face.tolerance, e.tolerance, of_node}),
                name("edge", use.edge) + " does not lie on its " + name("face", f) + ": it is off");
    }
    if (!is_closed(f)) fatal("the border of " + name("face", f) + " is not closed");
  }
}

}  // namespace

ModelDefects defects_of(const GeometryModel& model) { return Checker(model).run(); }

}  // namespace weft::meshing
