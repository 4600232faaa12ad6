// Vertices find the faces near them, triangles the face that all their vertices share, edges between faces
// the model's edge, and the model's nodes their vertices.
#include "meshing/geometry/model/model_classification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <queue>
#include <span>

#include "meshing/base/error.h"
#include "meshing/base/parallel.h"
#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"
#include "meshing/geometry/model/closest_tree.h"

namespace weft::meshing {
namespace {

// Of the model's size: what lies nearer lies on it; what lies farther than the second does not belong to it.
constexpr double kOn = 1e-6, kFar = 0.01;
// As far may a vertex be from where its record says.
constexpr double kRecorded = 1e-4;
// Of the longest edge at a vertex: a vertex farther off does not follow the model.
constexpr double kFarOfEdge = 0.25;
constexpr double kNearlyAsNear = 1.5;
// Fewer vertices than this share on the model: it is another body's.
constexpr double kLeastShare = 1.0 / 3;
// So too where less of the mesh's boundary lies on it and less of the model has triangles on it. A body amid
// its surroundings has little of the mesh's boundary, but all of the model; half a body half of it.
constexpr double kLeastOfMesh = 0.5, kLeastOfModel = 0.4;
// Of the model's size: so far off, by their root mean square, vertices are beside the model, where a scale
// and a shift explain that much of the squares. (A mesh of chords is off otherwise: not at their ends.)
constexpr double kBeside = 5e-4, kExplained = 0.95;

/// A triangle or an edge of the boundary seen from an edge: (lower vertex, higher vertex), triangle.
struct Side {
  std::array<std::uint32_t, 2> vertices;
  std::uint32_t triangle;
  friend auto operator<=>(const Side&, const Side&) = default;
};

/// What a vertex lies on: a node, else an edge, else a face.
struct Carrier {
  enum class Kind : std::uint8_t { none, node, edge, face };
  Kind kind = Kind::none;
  std::uint32_t entity = kNoEntity;
  Parameters guess{};  ///< on a face without formula
};

/// By more than rounding: what is as far, to the bit, is not beyond it.
double square_above(double distance) {
  constexpr double kRounding = 1 + 1e-12;
  return kRounding * distance * distance;
}

using Tallies = std::map<std::pair<std::uint32_t, std::int32_t>, FaceTally>;  // by face and reference

void add(const FaceTally& tally, Tallies& all) {
  const auto [at, fresh] = all.try_emplace({tally.face, tally.ref}, tally);
  if (!fresh) at->second.add(tally);
}

class Classifier {
 public:
  Classifier(const BoundaryDomain& domain, std::shared_ptr<const Model> model)
      : domain_(domain), mesh_(domain.mesh()), model_(*model) {
    c_.model = std::move(model);
  }

  ModelClassification run() {
    measure_edges();
    find_vertices();
    sort_sides();
    take_records();
    find_faces_of_vertices();
    refuse_another_body();
    find_faces_of_triangles();
    fill_gaps();
    refuse_another_shape();
    refuse_another_place();
    find_nodes();
    find_edges();
    group_faces();
    find_carriers();
    set_parameters();
    find_faults();
    judge_triangles();
    return std::move(c_);
  }

 private:
  struct Candidate {
    std::uint32_t face;
    double distance;
  };

  void measure_edges();
  void find_vertices();
  void take_records();
  bool fits(const Association::OnNode& record) const;
  bool fits(const Association::OnEdge& record) const;
  bool fits(const Association::OnFace& record) const;
  void find_faces_of_vertices();
  std::vector<Candidate> faces_near(std::uint32_t v) const;
  void refuse_another_body() const;
  void refuse_another_shape() const;
  double mean_square_beside() const;
  void refuse_another_place() const;
  double area_of_face(std::uint32_t f) const;
  std::vector<double> areas_on_faces() const;
  std::string distances() const;
  std::string hint_of_scale() const;
  void find_faces_of_triangles();
  std::vector<std::uint32_t> shared_faces(const std::array<std::uint32_t, 3>& t) const;
  bool references_are_faces() const;
  std::uint32_t face_of_triangle(std::uint32_t triangle, bool by_reference) const;
  void fill_gaps();
  std::uint32_t face_beside(std::uint32_t triangle, std::span<const std::uint8_t> is_new) const;
  void sort_sides();
  std::vector<NearVertex> nearest_to_nodes() const;
  void find_nodes();
  void find_edges();
  void consider_edge(std::size_t begin, std::size_t end, bool listed);
  bool is_end_of(std::uint32_t v, std::uint32_t e) const;
  std::uint32_t edge_between(const std::array<std::uint32_t, 2>& v, std::span<const std::uint32_t> faces,
                             std::array<double, 2>& t) const;
  std::array<double, 2> parameters_along(std::uint32_t e, const std::array<std::uint32_t, 2>& v) const;
  void group_faces();
  void find_carriers();
  void set_parameters();
  std::vector<std::uint32_t> triangles_with_parameters() const;
  Parameters unwrapped(std::uint32_t f, Parameters at, const Parameters& middle) const;
  void find_faults();
  std::vector<Carrier> places() const;
  double distance_from(const Carrier& place, const Point& p) const;
  double tolerance_of(const Carrier& place) const;
  /// Parameters to begin from: of a corner of a triangle, of its centroid.
  Parameters guess(std::size_t triangle, std::size_t corner) const {
    return c_.parameters.empty() ? Parameters{} : c_.parameters[triangle][corner];
  }
  Parameters guess(std::size_t triangle) const {
    Parameters middle{};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t j = 0; j < 2; ++j) middle[j] += guess(triangle, k)[j] / 3;
    return middle;
  }
  void judge_triangles();
  Tallies tallies() const;
  void warn(const Tallies& all);

  double on() const { return kOn * model_.size(); }
  double tolerance_at(std::uint32_t node) const { return std::max(on(), 2 * model_.node_tolerance(node)); }
  static bool is_id(std::int32_t id, std::size_t count) {
    return id >= 1 && id <= static_cast<std::int64_t>(count);
  }
  static std::uint32_t index_of(std::int32_t id) { return static_cast<std::uint32_t>(id - 1); }
  bool is_at(std::uint32_t v, const Point& recorded) const {
    return norm(recorded - mesh_.points[v]) <= kRecorded * model_.size();
  }
  double reach(std::uint32_t v) const {
    return std::max(on(), std::min(kFarOfEdge * longest_[v], kFar * model_.size()));
  }
  bool has_record(std::uint32_t v, std::uint32_t face) const {
    return std::binary_search(face_records_.begin(), face_records_.end(), std::pair{v, face});
  }

  const BoundaryDomain& domain_;
  const MeshData& mesh_;
  const Model& model_;
  ModelClassification c_;
  std::vector<double> longest_;               // edge at a vertex; 0: not of the boundary
  std::vector<std::uint32_t> vertices_;       // of own triangles
  std::vector<std::uint8_t> is_here_;         // whether a vertex is one of these
  std::vector<std::uint32_t> counted_;        // of these; each vertex of the boundary in one part
  std::uint64_t num_vertices_ = 0;            // of all parts
  Box box_;                                   // of theirs
  std::vector<std::vector<Candidate>> near_;  // of each vertex, nearest first
  std::vector<double> distance_;              // of each vertex from the nearest face
  std::vector<Side> sides_;
  std::vector<std::uint32_t> carrier_;  // of each vertex: the last triangle at it that lies on a face
  std::vector<std::pair<std::uint32_t, std::uint32_t>> face_records_,
      edge_records_;  // (vertex, entity), sorted
  std::vector<std::pair<std::uint32_t, std::uint32_t>> node_records_;
  std::vector<std::array<std::uint32_t, 2>> uncut_;  // pairs of faces that the mesh does not keep apart
};

void Classifier::measure_edges() {
  longest_.assign(mesh_.points.size(), 0);
  for (const auto& t : mesh_.triangles)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      const double length = norm(mesh_.points[a] - mesh_.points[b]);
      for (const std::uint32_t v : {a, b}) longest_[v] = std::max(longest_[v], length);
    }
}

/// A vertex counts where its last triangle is: who has an own triangle at it has all.
void Classifier::find_vertices() {
  is_here_.assign(mesh_.points.size(), 0);
  std::vector<std::uint8_t> last_is_own(mesh_.points.size(), 0);
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i)
    for (const std::uint32_t v : mesh_.triangles[i]) {
      last_is_own[v] = domain_.owns(i);
      is_here_[v] |= last_is_own[v];
    }
  for (std::uint32_t v = 0; v < longest_.size(); ++v) {
    is_here_[v] &= longest_[v] > 0;
    if (!is_here_[v]) continue;
    vertices_.push_back(v);
    if (!last_is_own[v]) continue;
    counted_.push_back(v);
    box_.include(mesh_.points[v]);
  }
  num_vertices_ = domain_.sum(counted_.size());
  box_ = domain_.unite(box_);
}

/// Whether the model has a record's entity, and it gives back the vertex.
bool Classifier::fits(const Association::OnNode& r) const {
  return is_id(r.id, model_.num_nodes()) && is_at(r.vertex, model_.node(index_of(r.id)));
}

bool Classifier::fits(const Association::OnEdge& r) const {
  if (!is_id(r.id, model_.num_edges())) return false;
  const ModelEdge& edge = model_.edge(index_of(r.id));
  if (!edge.degenerate) return is_at(r.vertex, model_.curve(index_of(r.id), r.t).x);
  return edge.nodes[0] == kNoEntity || is_at(r.vertex, model_.node(edge.nodes[0]));
}

bool Classifier::fits(const Association::OnFace& r) const {
  return is_id(r.id, model_.num_faces()) && is_at(r.vertex, model_.surface(index_of(r.id), {r.u, r.v}).x);
}

/// Records of another file of the same body fit but for some: its nodes and edges may count otherwise. A
/// record that does not fit is none; where more than one in ten do not, those that fit do so by chance.
void Classifier::take_records() {
  std::vector<std::uint64_t> counts(2);  // of records, and of those that do not fit
  const auto take = [&](const auto& records, auto& taken) {
    for (const auto& r : records) {
      if (!is_here_[r.vertex]) continue;
      const bool fit = fits(r);
      if (fit) taken.emplace_back(r.vertex, index_of(r.id));
      if (!std::ranges::binary_search(counted_, r.vertex)) continue;
      ++counts[0];
      counts[1] += !fit;
    }
  };
  domain_.run([&] {
    take(mesh_.association.nodes, node_records_);
    take(mesh_.association.edges, edge_records_);
    take(mesh_.association.faces, face_records_);
  });
  counts = domain_.sum(std::move(counts));
  const std::uint64_t given = counts[0], wrong = counts[1];
  if (10 * wrong > given) {
    for (auto* list : {&face_records_, &edge_records_, &node_records_}) list->clear();
    c_.warnings.push_back(
        "the mesh's records of where its vertices lie on a model do not fit this model and are not used");
    return;
  }
  if (wrong > 0)
    c_.warnings.push_back(
        fmt::format("{} of the mesh's {} records of where its vertices lie on a model do not fit this model "
                    "and are not used",
                    wrong, given));
  // A vertex on an edge is on the edge's faces too, whether that is recorded or not.
  for (const auto& [v, e] : edge_records_)
    for (const std::uint32_t f : model_.faces_at_edge(e)) face_records_.emplace_back(v, f);
  for (const auto& [v, n] : node_records_)
    for (const std::uint32_t e : model_.edges_at_node(n))
      for (const std::uint32_t f : model_.faces_at_edge(e)) face_records_.emplace_back(v, f);
  for (auto* list : {&face_records_, &edge_records_, &node_records_}) sort_unique(*list);
}

/// The faces that a vertex may lie on: those it is on, else the nearest and what is nearly as near.
std::vector<Classifier::Candidate> Classifier::faces_near(std::uint32_t v) const {
  const Point& p = mesh_.points[v];
  std::vector<Candidate> found;
  const auto recorded =
      std::lower_bound(face_records_.begin(), face_records_.end(), std::pair{v, std::uint32_t{0}});
  for (auto r = recorded; r != face_records_.end() && r->first == v; ++r)
    found.push_back({r->second, model_.closest_within(r->second, p).distance});
  if (!found.empty()) return found;
  std::vector<std::pair<double, std::uint32_t>> boxes;
  for (std::uint32_t f = 0; f < model_.num_faces(); ++f)
    boxes.emplace_back(std::sqrt(model_.face_box(f).distance2(p)), f);
  // A heap, since of many faces few are looked at.
  double nearest = kUnbounded;
  for (std::priority_queue order(std::greater{}, std::move(boxes)); !order.empty(); order.pop()) {
    const auto [least, f] = order.top();
    if (least > std::max(kNearlyAsNear * nearest, nearest + on())) break;
    const double d = model_.closest_within(f, p).distance;
    nearest = std::min(nearest, d);
    found.push_back({f, d});
  }
  const double limit = nearest <= on() ? on() : std::max(kNearlyAsNear * nearest, nearest + on());
  std::erase_if(found, [&](const Candidate& c) {
    return c.distance > std::max(limit, 2 * model_.face_tolerance(c.face));
  });
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.face < b.face;
  });
  return found;
}

void Classifier::find_faces_of_vertices() {
  near_.resize(mesh_.points.size());
  distance_.assign(mesh_.points.size(), kUnbounded);
  domain_.run([&] {
    tbb::parallel_for(std::size_t{0}, vertices_.size(), [&](std::size_t i) {
      const std::uint32_t v = vertices_[i];
      near_[v] = faces_near(v);
      for (const Candidate& c : near_[v]) distance_[v] = std::min(distance_[v], c.distance);
      if (distance_[v] > std::max(reach(v), 2 * model_.face_tolerance(near_[v].front().face)) &&
          !has_record(v, near_[v].front().face))
        near_[v].clear();
    });
  });
}

/// What the boxes tell of a wrong unit.
std::string Classifier::hint_of_scale() const {
  const double factor = norm(box_.size()) / model_.size();
  if (std::abs(factor - 1) < 0.05) return "";
  for (int i = 0; i < 3; ++i)
    if (std::abs(box_.size()[i] - factor * model_.box().size()[i]) > 0.05 * norm(box_.size())) return "";
  return fmt::format(". The mesh is {:.3g} times as large as the model: --geometry-scale {:.3g}?", factor,
                     factor * model_.scale());
}

void Classifier::refuse_another_body() const {
  std::uint64_t on_model = 0;
  for (const std::uint32_t v : counted_) on_model += !near_[v].empty();
  on_model = domain_.sum(on_model);
  if (static_cast<double>(on_model) >= kLeastShare * static_cast<double>(num_vertices_)) return;
  throw InputError(
      model_.geometry().name(), "",
      fmt::format("is not the model of this mesh: of {} vertices of the boundary {} lie on it, {}{}",
                  num_vertices_, on_model, distances(), hint_of_scale()));
}

/// Of vertices from the model.
std::string Classifier::distances() const {
  std::vector<double> mine;
  for (const std::uint32_t v : counted_) mine.push_back(distance_[v]);
  const std::vector<double> found =
      domain_.select(std::move(mine), std::array{num_vertices_ / 2, num_vertices_ - 1});
  return fmt::format("half of them are farther than {:.3g} from it and one {:.3g}, where its size is {:.3g}",
                     found[0], found[1], model_.size());
}

/// Within its border, roughly.
double Classifier::area_of_face(std::uint32_t f) const {
  constexpr int kCells = 32;
  const ModelFace& face = model_.face(f);
  const double du = (face.hi[0] - face.lo[0]) / kCells, dv = (face.hi[1] - face.lo[1]) / kCells;
  double area = 0;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const Parameters at{face.lo[0] + (i + 0.5) * du, face.lo[1] + (j + 0.5) * dv};
      if (!model_.is_inside(f, at)) continue;
      const SurfaceJet jet = model_.surface(f, at);
      area += norm(cross(jet.du, jet.dv)) * du * dv;
    }
  return area;
}

/// Of the mesh on each face of the model; at last on none.
std::vector<double> Classifier::areas_on_faces() const {
  const int exponent = exponent_above(norm2(box_.size()));
  std::vector<FixedPointSum> sums(model_.num_faces() + 1);
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    if (!domain_.owns(i)) continue;
    const auto& [a, b, c] = mesh_.triangles[i];
    const double twice = norm(cross(mesh_.points[b] - mesh_.points[a], mesh_.points[c] - mesh_.points[a]));
    sums[std::min<std::size_t>(c_.triangle_face[i], model_.num_faces())].add(0.5 * twice, exponent);
  }
  std::vector<double> areas;
  for (const FixedPointSum& sum : domain_.sum(std::move(sums))) areas.push_back(sum.value(exponent));
  return areas;
}

/// By areas: vertices of another body may lie on the model by chance, as those of a plane through it.
void Classifier::refuse_another_shape() const {
  if (num_vertices_ == 0) return;
  const std::vector<double> areas = areas_on_faces();
  const double all = std::accumulate(areas.begin(), areas.end(), 0.0), on_model = all - areas.back();
  if (on_model >= kLeastOfMesh * all) return;
  double of_model = 0, covered = 0;
  domain_.run([&] {
    for (std::uint32_t f = 0; f < model_.num_faces(); ++f) {
      const double area = area_of_face(f);
      of_model += area;
      covered += std::min(area, areas[f]);
    }
  });
  if (covered >= kLeastOfModel * of_model) return;
  throw InputError(
      model_.geometry().name(), "",
      fmt::format("is not the model of this mesh: {:.0f} % of the mesh's boundary lie on it, on {:.0f} % of "
                  "its area; of the boundary's vertices {}{}",
                  100 * on_model / all, 100 * covered / of_model, distances(), hint_of_scale()));
}

namespace {

constexpr std::size_t kUnknowns = 7;
using Unknowns = std::array<double, kUnknowns>;

/// Least squares of the seven unknowns of a similarity: scale, shift, turn; kept regular. Of sums that are
/// the same bits in any order.
class Fit {
 public:
  static constexpr std::size_t kSums = (kUnknowns + 2) * (kUnknowns + 3) / 2;
  static constexpr int kExponent = 4;

  /// An equation; its numbers are of the order of 1 or below.
  static void add(const Unknowns& row, double value, std::vector<FixedPointSum>& sums) {
    std::array<double, kUnknowns + 2> all{};
    std::ranges::copy(row, all.begin());
    all[kUnknowns] = value;
    all[kUnknowns + 1] = 1;
    for (std::size_t i = 0, at = 0; i < all.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j) sums[at++].add(all[i] * all[j], kExponent);
  }

  explicit Fit(const std::vector<FixedPointSum>& sums) {
    const auto sum = [&](std::size_t i, std::size_t j) { return sums[i * (i + 1) / 2 + j].value(kExponent); };
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      right_[i] = sum(kUnknowns, i);
      for (std::size_t j = 0; j <= i; ++j) matrix_[i][j] = matrix_[j][i] = sum(i, j);
    }
    squares_ = sum(kUnknowns, kUnknowns);
    count_ = sum(kUnknowns + 1, kUnknowns + 1);
  }
  Unknowns solution() const;
  /// The share of the squares that the solution explains.
  double explained(const Unknowns& x) const {
    double sum = 0;
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      sum += 2 * x[i] * right_[i];
      for (std::size_t j = 0; j < kUnknowns; ++j) sum -= x[i] * matrix_[i][j] * x[j];
    }
    return squares_ > 0 ? sum / squares_ : 0;
  }

 private:
  std::array<Unknowns, kUnknowns> matrix_{};
  Unknowns right_{};
  double squares_ = 0, count_ = 0;
};

Unknowns Fit::solution() const {
  auto a = matrix_;
  auto x = right_;
  for (std::size_t i = 0; i < kUnknowns; ++i) a[i][i] += 1e-6 * count_;
  for (std::size_t i = 0; i < kUnknowns; ++i)  // positive definite: no pivots
    for (std::size_t k = i + 1; k < kUnknowns; ++k) {
      const double factor = a[k][i] / a[i][i];
      for (std::size_t j = i; j < kUnknowns; ++j) a[k][j] -= factor * a[i][j];
      x[k] -= factor * x[i];
    }
  for (std::size_t i = kUnknowns; i-- > 0;) {
    for (std::size_t j = i + 1; j < kUnknowns; ++j) x[i] -= a[i][j] * x[j];
    x[i] /= a[i][i];
  }
  return x;
}

}  // namespace

/// The mean square of how far the vertices on the model are off it, as a share of its size.
double Classifier::mean_square_beside() const {
  std::vector<FixedPointSum> squares(1);
  std::uint64_t count = 0;
  domain_.run([&] {
    for (const std::uint32_t v : counted_) {
      if (near_[v].empty()) continue;
      const OnFace q = model_.closest_within(near_[v].front().face, mesh_.points[v]);
      const Vec away = mesh_.points[v] - q.x;
      const double off = dot(norm(away) > on() ? normalized(away) : q.normal, away) / model_.size();
      squares[0].add(off * off, Fit::kExponent);
      ++count;
    }
  });
  squares = domain_.sum(std::move(squares));
  count = domain_.sum(count);
  return count > 0 ? squares[0].value(Fit::kExponent) / static_cast<double>(count) : 0;
}

/// The mesh as a whole may be a little too large, or beside its place: each vertex is near the model then,
/// but they are off it as a similarity would have it. Most meshes are not, and nothing is fitted.
void Classifier::refuse_another_place() const {
  if (mean_square_beside() <= kBeside * kBeside) return;
  std::vector<FixedPointSum> sums(Fit::kSums);
  const double size = model_.size();
  const Point middle = 0.5 * (model_.box().lo + model_.box().hi);
  domain_.run([&] {
    for (const std::uint32_t v : counted_) {
      if (near_[v].empty()) continue;
      const OnFace q = model_.closest_within(near_[v].front().face, mesh_.points[v]);
      const Vec away = mesh_.points[v] - q.x, from_middle = (1 / size) * (mesh_.points[v] - middle);
      const Vec u = norm(away) > on() ? normalized(away) : q.normal, turn = cross(from_middle, u);
      Fit::add({dot(u, from_middle), u.x, u.y, u.z, turn.x, turn.y, turn.z}, dot(u, away) / size, sums);
    }
  });
  const Fit fit(domain_.sum(std::move(sums)));
  const Unknowns x = fit.solution();
  if (fit.explained(x) < kExplained) return;
  throw InputError(model_.geometry().name(), "",
                   fmt::format("is not the model of this mesh as it is: it looks {:.4g} times as large, "
                               "shifted by ({:.3g}, {:.3g}, "
                               "{:.3g}) and turned by {:.2g} degrees; of the boundary's vertices {}",
                               1 / (1 - x[0]), x[1] * size, x[2] * size, x[3] * size,
                               std::hypot(x[4], x[5], x[6]) * 180 / std::numbers::pi, distances()));
}

/// The faces that all vertices of a triangle may lie on.
std::vector<std::uint32_t> Classifier::shared_faces(const std::array<std::uint32_t, 3>& t) const {
  std::vector<std::uint32_t> shared;
  for (const Candidate& c : near_[t[0]]) {
    const auto has = [&](std::uint32_t v) {
      return std::ranges::any_of(near_[v], [&](const Candidate& x) { return x.face == c.face; });
    };
    if (has(t[1]) && has(t[2])) shared.push_back(c.face);
  }
  return shared;
}

/// Whether references are the faces' ids, as far as vertices alone tell the faces.
bool Classifier::references_are_faces() const {
  std::vector<std::uint64_t> counts(2);  // of triangles that are told one face, and of those that agree
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    if (!domain_.owns(i)) continue;
    const std::vector<std::uint32_t> shared = shared_faces(mesh_.triangles[i]);
    if (shared.size() != 1) continue;
    ++counts[0];
    counts[1] += mesh_.triangle_refs[i] == static_cast<std::int64_t>(shared.front()) + 1;
  }
  counts = domain_.sum(std::move(counts));
  return counts[0] > 0 && counts[1] == counts[0];
}

/// By the vertices; where these allow several, by the reference or by the place and the normal. Of a narrow
/// face beside a curved one a coarse triangle is as far from both, and its normal is any.
std::uint32_t Classifier::face_of_triangle(std::uint32_t triangle, bool by_reference) const {
  const auto& t = mesh_.triangles[triangle];
  const std::vector<std::uint32_t> shared = shared_faces(t);
  if (shared.size() < 2) return shared.empty() ? kNoEntity : shared.front();
  if (by_reference)
    for (const std::uint32_t f : shared)
      if (mesh_.triangle_refs[triangle] == static_cast<std::int64_t>(f) + 1) return f;
  const Point &a = mesh_.points[t[0]], &b = mesh_.points[t[1]], &c = mesh_.points[t[2]];
  const Point centroid = (1.0 / 3) * (a + b + c);
  const Vec n = cross(b - a, c - a);
  const double size = std::sqrt(norm(n));
  std::uint32_t best = kNoEntity;
  double best_score = kUnbounded;
  for (const std::uint32_t f : shared) {
    const OnFace q = model_.closest_within(f, centroid);
    const double turn = norm(n) > 0 ? 1 - std::abs(dot(n, q.normal)) / norm(n) : 0;
    const double score = q.distance + 0.5 * size * turn;
    if (score < best_score) best = f, best_score = score;
  }
  return best;
}

void Classifier::find_faces_of_triangles() {
  c_.triangle_face.assign(mesh_.triangles.size(), kNoEntity);
  const bool by_reference = references_are_faces();
  domain_.run([&] {
    for_each_index(mesh_.triangles.size(), [&](std::size_t i) {
      if (domain_.owns(i))
        c_.triangle_face[i] = face_of_triangle(static_cast<std::uint32_t>(i), by_reference);
    });
  });
  domain_.refresh(c_.triangle_face);
}

void Classifier::sort_sides() {
  for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh_.triangles[i][k], b = mesh_.triangles[i][(k + 1) % 3];
      sides_.push_back({{std::min(a, b), std::max(a, b)}, i});
    }
  std::sort(sides_.begin(), sides_.end());
}

/// Of the first neighbour with the triangle's reference on whose face all vertices of the triangle are. Only
/// those whose faces are new are tried.
std::uint32_t Classifier::face_beside(std::uint32_t triangle, std::span<const std::uint8_t> is_new) const {
  const auto& t = mesh_.triangles[triangle];
  const auto fits = [&](std::uint32_t f) {
    return std::ranges::all_of(
        t, [&](std::uint32_t v) { return model_.closest_within(f, mesh_.points[v]).distance <= reach(v); });
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
    for (const Side& side : std::ranges::equal_range(sides_, std::array{a, b}, {}, &Side::vertices)) {
      const std::uint32_t f = c_.triangle_face[side.triangle];
      if (f != kNoEntity && is_new[side.triangle] &&
          mesh_.triangle_refs[side.triangle] == mesh_.triangle_refs[triangle] && fits(f))
        return f;
    }
  }
  return kNoEntity;
}

/// A triangle whose vertices share no face takes that of a neighbour which it is near to; so on from
/// neighbour to neighbour, all of one round by what was known before it.
void Classifier::fill_gaps() {
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < c_.triangle_face.size(); ++i)
    if (domain_.owns(i) && c_.triangle_face[i] == kNoEntity) open.push_back(i);
  if (domain_.sum(open.size()) == 0) return;
  std::vector<std::uint8_t> is_new(c_.triangle_face.size(), 1);  // what has not fitted once will not
  for (;;) {
    std::vector<std::uint32_t> found;
    domain_.run([&] {
      for (const std::uint32_t i : open) found.push_back(face_beside(i, is_new));
    });
    const auto none = static_cast<std::uint64_t>(std::ranges::count(found, kNoEntity));
    if (domain_.sum(found.size() - none) == 0) return;
    const std::vector<std::uint32_t> before = c_.triangle_face;
    for (std::size_t k = 0; k < open.size(); ++k) c_.triangle_face[open[k]] = found[k];
    std::erase_if(open, [&](std::uint32_t i) { return c_.triangle_face[i] != kNoEntity; });
    domain_.refresh(c_.triangle_face);
    for (std::size_t i = 0; i < is_new.size(); ++i) is_new[i] = c_.triangle_face[i] != before[i];
  }
}

/// The nearest vertex to each node that no record names, of those that lie on it or on all its faces.
std::vector<NearVertex> Classifier::nearest_to_nodes() const {
  std::vector<std::uint64_t> recorded(model_.num_nodes(), 0);
  for (const auto& [v, n] : node_records_) recorded[n] = 1;
  recorded = domain_.sum(std::move(recorded));
  const auto touches = [&](std::uint32_t v, std::uint32_t n) {
    for (const std::uint32_t e : model_.edges_at_node(n))
      for (const std::uint32_t f : model_.faces_at_edge(e))
        if (std::ranges::none_of(near_[v], [&](const Candidate& c) { return c.face == f; })) return false;
    return true;
  };
  std::vector<NearVertex> nearest(model_.num_nodes());
  if (counted_.empty()) return domain_.nearest(std::move(nearest));
  std::vector<ClosestForest::Item> items;
  double farthest = 0;
  for (const std::uint32_t v : counted_) {
    items.push_back({{mesh_.points[v], mesh_.points[v]}, v});
    farthest = std::max(farthest, reach(v));
  }
  ClosestForest tree;
  const std::uint32_t root = tree.add(items);
  for (std::uint32_t n = 0; n < nearest.size(); ++n) {
    if (recorded[n]) continue;
    const Point at = model_.node(n);
    double limit2 = square_above(std::max(farthest, tolerance_at(n)));
    tree.visit_within(root, at, limit2, [&](std::uint32_t v) {
      const NearVertex found{norm(mesh_.points[v] - at), domain_.number(v)};
      if (!(found < nearest[n])) return;
      if (found.distance > tolerance_at(n) && !(found.distance <= reach(v) && touches(v, n))) return;
      nearest[n] = found;
      limit2 = square_above(found.distance);
    });
  }
  return domain_.nearest(std::move(nearest));
}

/// The vertex of each node: recorded, else the nearest.
void Classifier::find_nodes() {
  c_.nodes = node_records_;
  const std::vector<NearVertex> nearest = nearest_to_nodes();
  for (std::uint32_t n = 0; n < nearest.size(); ++n) {
    if (nearest[n].distance == kUnbounded) continue;
    // A node amid a smooth curve or face is one only where a vertex is put on it.
    if (nearest[n].distance > tolerance_at(n) && model_.edges_at_node(n).size() < 3) continue;
    const std::uint32_t v = domain_.vertex(static_cast<std::uint32_t>(nearest[n].number));
    if (v != kNoEntity && is_here_[v]) c_.nodes.emplace_back(v, n);
  }
  std::ranges::sort(c_.nodes);
  const auto rest = std::ranges::unique(c_.nodes, {}, &std::pair<std::uint32_t, std::uint32_t>::first);
  c_.nodes.erase(rest.begin(), rest.end());
}

/// The parameters of an edge's ends, such that what lies between them is the edge.
std::array<double, 2> Classifier::parameters_along(std::uint32_t e,
                                                   const std::array<std::uint32_t, 2>& v) const {
  const ModelEdge& m = model_.edge(e);
  std::array<double, 2> t{model_.closest_on_edge(e, mesh_.points[v[0]]).t,
                          model_.closest_on_edge(e, mesh_.points[v[1]]).t};
  const bool closed = m.nodes[0] == m.nodes[1];
  if (!closed) return t;
  const double middle = model_.closest_on_edge(e, midpoint(mesh_.points[v[0]], mesh_.points[v[1]])).t;
  const double turn = m.end - m.begin;
  for (double& x : t) {
    while (x - middle > 0.5 * turn) x -= turn;
    while (middle - x > 0.5 * turn) x += turn;
  }
  return t;
}

/// Whether a vertex is on one of the edge's nodes.
bool Classifier::is_end_of(std::uint32_t v, std::uint32_t e) const {
  const auto at = std::lower_bound(c_.nodes.begin(), c_.nodes.end(), std::pair{v, std::uint32_t{0}});
  if (at == c_.nodes.end() || at->first != v) return false;
  return std::ranges::find(model_.edge(e).nodes, at->second) != model_.edge(e).nodes.end();
}

/// The model's edge that a mesh edge lies on: both ends and, nearest, the middle; bordering all of `faces`.
std::uint32_t Classifier::edge_between(const std::array<std::uint32_t, 2>& v,
                                       std::span<const std::uint32_t> faces, std::array<double, 2>& t) const {
  const Point &a = mesh_.points[v[0]], &b = mesh_.points[v[1]], middle = midpoint(a, b);
  std::uint32_t best = kNoEntity;
  double best_distance = kUnbounded;
  const auto near = [&](std::uint32_t vertex, std::uint32_t e) {
    if (std::binary_search(edge_records_.begin(), edge_records_.end(), std::pair{vertex, e})) return true;
    // Curves end short of their nodes, by as much as the nodes' tolerance.
    if (is_end_of(vertex, e)) return true;
    const double d = model_.closest_on_edge(e, mesh_.points[vertex]).distance;
    // Exactly on one of the faces between which the edge is, it may be off the other.
    double off = distance_[vertex] < kUnbounded ? distance_[vertex] : 0;
    if (faces.size() > 1)
      for (const std::uint32_t f : faces)
        off = std::max(off, model_.closest_within(f, mesh_.points[vertex]).distance);
    const double slack = off <= on() ? on() : std::min(reach(vertex), 2 * kNearlyAsNear * off);
    return d <= std::max(slack, 2 * model_.edge_tolerance(e));
  };
  for (std::uint32_t e = 0; e < model_.num_edges(); ++e) {
    if (model_.edge(e).degenerate) continue;
    const auto at = model_.faces_at_edge(e);
    if (!std::ranges::all_of(faces, [&](std::uint32_t f) { return std::ranges::find(at, f) != at.end(); }))
      continue;
    const double bound = std::max(reach(v[0]), reach(v[1]));
    if (model_.edge_box(e).distance2(a) > bound * bound || !near(v[0], e) || !near(v[1], e)) continue;
    const double d = model_.closest_on_edge(e, middle).distance;
    if (d < best_distance) best = e, best_distance = d;
  }
  // A chord across a face whose ends lie on one closed edge is not on that edge.
  if (best != kNoEntity && best_distance > 0.3 * norm(b - a)) best = kNoEntity;
  if (best != kNoEntity) t = parameters_along(best, v);
  return best;
}

void Classifier::consider_edge(std::size_t begin, std::size_t end, bool listed) {
  std::vector<std::uint32_t> faces;
  bool unknown = false, own = false;
  for (std::size_t i = begin; i < end; ++i) {
    own |= domain_.owns(sides_[i].triangle);
    const std::uint32_t f = c_.triangle_face[sides_[i].triangle];
    unknown |= f == kNoEntity;
    if (f != kNoEntity && std::ranges::find(faces, f) == faces.end()) faces.push_back(f);
  }
  if (!own || faces.empty() || (faces.size() == 1 && !unknown && !listed && end - begin == 2)) return;
  EdgeOnModel found{.vertices = sides_[begin].vertices};
  found.edge = edge_between(found.vertices, faces, found.t);
  if (found.edge != kNoEntity) return c_.edges.push_back(found);
  for (std::size_t i = 1; i < faces.size(); ++i) uncut_.push_back({faces[0], faces[i]});
}

void Classifier::find_edges() {
  std::vector<std::array<std::uint32_t, 2>> listed;
  for (const auto& e : mesh_.edges) listed.push_back({std::min(e[0], e[1]), std::max(e[0], e[1])});
  std::sort(listed.begin(), listed.end());
  domain_.run([&] {
    for (std::size_t begin = 0, end; begin < sides_.size(); begin = end) {
      for (end = begin; end < sides_.size() && sides_[end].vertices == sides_[begin].vertices;) ++end;
      consider_edge(begin, end, std::binary_search(listed.begin(), listed.end(), sides_[begin].vertices));
    }
  });
  domain_.refresh(c_.edges);
}

/// Faces with a mesh edge between them that lies on no edge of the model are one to the mesh.
void Classifier::group_faces() {
  sort_unique(uncut_);
  uncut_ = domain_.all(std::move(uncut_));
  c_.face_group.resize(model_.num_faces());
  std::iota(c_.face_group.begin(), c_.face_group.end(), 0u);
  const auto root = [&](std::uint32_t f) {
    while (c_.face_group[f] != f) f = c_.face_group[f] = c_.face_group[c_.face_group[f]];
    return f;
  };
  for (const auto& [a, b] : uncut_) {
    const std::uint32_t x = root(a), y = root(b);
    c_.face_group[std::max(x, y)] = std::min(x, y);
  }
  for (std::uint32_t f = 0; f < c_.face_group.size(); ++f) c_.face_group[f] = root(f);
}

void Classifier::find_carriers() {
  carrier_.assign(mesh_.points.size(), kNoEntity);
  for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
    if (c_.triangle_face[i] != kNoEntity)
      for (const std::uint32_t v : mesh_.triangles[i]) carrier_[v] = i;
}

/// Own ones, and those that carry a vertex that is judged here; where the face has no formula.
std::vector<std::uint32_t> Classifier::triangles_with_parameters() const {
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i)
    if (domain_.owns(i)) all.push_back(i);
  for (const std::uint32_t v : counted_)
    if (carrier_[v] != kNoEntity) all.push_back(carrier_[v]);
  std::erase_if(all, [&](std::uint32_t i) {
    return c_.triangle_face[i] == kNoEntity || model_.has_formula(c_.triangle_face[i]);
  });
  sort_unique(all);
  return all;
}

/// On a periodic face within half a period of the middle, which lends its own where a parameter means nothing
/// (a pole).
Parameters Classifier::unwrapped(std::uint32_t f, Parameters at, const Parameters& middle) const {
  const SurfaceJet jet = model_.surface(f, at);
  const std::array<double, 2> speed{norm(jet.du), norm(jet.dv)};
  for (std::size_t j = 0; j < 2; ++j) {
    const double period = model_.face(f).period[j];
    if (period > 0) at[j] -= period * std::round((at[j] - middle[j]) / period);
    if (speed[j] < 1e-6 * speed[1 - j]) at[j] = middle[j];
  }
  return at;
}

/// Of corners, by the triangle's centroid.
void Classifier::set_parameters() {
  if (model_.has_formulas()) return;
  c_.parameters.resize(mesh_.triangles.size());
  const std::vector<std::uint32_t> triangles = triangles_with_parameters();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> asked;  // (vertex, face)
  for (const std::uint32_t i : triangles)
    for (const std::uint32_t v : mesh_.triangles[i]) asked.emplace_back(v, c_.triangle_face[i]);
  sort_unique(asked);
  domain_.run([&] {
    std::vector<Parameters> answers(asked.size());
    tbb::parallel_for(std::size_t{0}, asked.size(), [&](std::size_t k) {
      answers[k] = model_.closest_on_face(asked[k].second, mesh_.points[asked[k].first]).at;
    });
    tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t j) {
      const std::uint32_t i = triangles[j], f = c_.triangle_face[i];
      const auto& t = mesh_.triangles[i];
      const Point centroid = (1.0 / 3) * (mesh_.points[t[0]] + mesh_.points[t[1]] + mesh_.points[t[2]]);
      const Parameters middle = model_.closest_on_face(f, centroid).at;
      for (std::size_t k = 0; k < 3; ++k) {
        const Parameters& at = answers[place_in(asked, std::pair{t[k], f})];
        c_.parameters[i][k] = unwrapped(f, at, middle);
      }
    });
  });
}

/// Where each vertex that counts here lies.
std::vector<Carrier> Classifier::places() const {
  std::vector<Carrier> places(mesh_.points.size());
  for (const std::uint32_t v : counted_)
    if (const std::uint32_t i = carrier_[v]; i != kNoEntity) {
      const auto corner =
          static_cast<std::size_t>(std::ranges::find(mesh_.triangles[i], v) - mesh_.triangles[i].begin());
      places[v] = {Carrier::Kind::face, c_.triangle_face[i], guess(i, corner)};
    }
  for (const EdgeOnModel& e : c_.edges)
    for (const std::uint32_t v : e.vertices) places[v] = {Carrier::Kind::edge, e.edge, {}};
  for (const auto& [v, n] : c_.nodes) places[v] = {Carrier::Kind::node, n, {}};
  return places;
}

double Classifier::distance_from(const Carrier& place, const Point& p) const {
  switch (place.kind) {
    case Carrier::Kind::node:
      return norm(p - model_.node(place.entity));
    case Carrier::Kind::edge:
      return model_.closest_on_edge(place.entity, p).distance;
    case Carrier::Kind::face:
      return model_.closest_on_face(place.entity, p, place.guess).distance;
    default:
      return 0;
  }
}

double Classifier::tolerance_of(const Carrier& place) const {
  switch (place.kind) {
    case Carrier::Kind::node:
      return model_.node_tolerance(place.entity);
    case Carrier::Kind::edge:
      return model_.edge_tolerance(place.entity);
    case Carrier::Kind::face:
      return model_.face_tolerance(place.entity);
    default:
      return 0;
  }
}

void Classifier::find_faults() {
  const std::vector<Carrier> places = this->places();
  std::vector<double> distance(counted_.size(), 0);
  std::vector<std::uint8_t> off(counted_.size(), 0);
  domain_.run([&] {
    for_each_index(counted_.size(), [&](std::size_t i) {
      const Carrier& at = places[counted_[i]];
      distance[i] = distance_from(at, mesh_.points[counted_[i]]);
      off[i] = distance[i] > std::max(kOffModel * model_.size(), tolerance_of(at));
    });
  });
  for (std::size_t i = 0; i < off.size(); ++i) {
    c_.faults.off += off[i];
    c_.faults.largest = std::max(c_.faults.largest, distance[i]);
  }
  c_.faults.off = domain_.sum(c_.faults.off);
  c_.faults.largest = domain_.max(c_.faults.largest);
}

/// Of own triangles.
Tallies Classifier::tallies() const {
  std::vector<std::int8_t> side(mesh_.triangles.size(), 0);
  for_each_index(mesh_.triangles.size(), [&](std::size_t i) {
    const std::uint32_t f = c_.triangle_face[i];
    if (f == kNoEntity || !domain_.owns(i)) return;
    const auto& t = mesh_.triangles[i];
    const Point &a = mesh_.points[t[0]], &b = mesh_.points[t[1]], &c = mesh_.points[t[2]];
    const OnFace q = model_.closest_on_face(f, (1.0 / 3) * (a + b + c), guess(i));
    const double along = dot(cross(b - a, c - a), q.normal);
    side[i] = along > 0 ? 1 : along < 0 ? -1 : 0;
  });
  Tallies all;
  for (std::size_t i = 0; i < side.size(); ++i) {
    if (!domain_.owns(i)) continue;
    FaceTally tally{c_.triangle_face[i], mesh_.triangle_refs[i], 1};
    if (side[i] != 0) tally.sides[side[i] > 0] = 1;
    if (tally.face == kNoEntity)
      for (const std::uint32_t v : mesh_.triangles[i])
        tally.farthest = std::max(tally.farthest, distance_[v]);
    add(tally, all);
  }
  return all;
}

/// Files may list triangles turned as it comes: most of those on a face with one reference are right.
void Classifier::judge_triangles() {
  std::vector<FaceTally> mine;
  domain_.run([&] {
    for (const auto& [key, tally] : tallies()) mine.push_back(tally);
  });
  Tallies all;
  for (const FaceTally& tally : domain_.all(std::move(mine))) add(tally, all);
  for (const auto& [key, tally] : all) c_.faults.turned += std::min(tally.sides[0], tally.sides[1]);
  warn(all);
}

/// Names what lies on no face by the references of its triangles, and faces that nothing lies on.
void Classifier::warn(const Tallies& all) {
  std::vector<std::uint8_t> used(model_.num_faces(), 0);
  for (const auto& [key, tally] : all)
    if (tally.face != kNoEntity)
      used[tally.face] = 1;
    else
      c_.warnings.push_back(fmt::format(
          "{} triangles of reference {} lie on no face of the model (up to {:.3g} from it): their "
          "surface is reconstructed",
          tally.triangles, tally.ref, tally.farthest));
  std::string list;
  int missing = 0;
  for (std::uint32_t f = 0; f < used.size(); ++f)
    if (!used[f] && ++missing <= 10) list += (list.empty() ? "" : ", ") + std::to_string(f + 1);
  if (missing > 0)
    c_.warnings.push_back(fmt::format("faces of the model that no triangle lies on: {}{}", list,
                                      missing > 10 ? fmt::format(" and {} more", missing - 10) : ""));
}

}  // namespace

ModelClassification classify_on_model(const MeshData& boundary, std::shared_ptr<const Model> model) {
  return classify_on_model(WholeBoundaryDomain(boundary), std::move(model));
}

ModelClassification classify_on_model(const BoundaryDomain& part, std::shared_ptr<const Model> model) {
  return Classifier(part, std::move(model)).run();
}

}  // namespace weft::meshing
