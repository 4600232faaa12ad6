// Where a share ends, what is beyond is known from its owner.
#include "partition/surface/surface_parts.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/place_in.h"
#include "meshing/base/release.h"
#include "meshing/base/sort_unique.h"
#include "meshing/geometry/surface/cut_surface.h"
#include "meshing/geometry/surface/model_tables.h"
#include "meshing/geometry/surface/surface_shape.h"
#include "meshing/geometry/surface/surface_tables.h"
#include "meshing/geometry/surface/surface_topology.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/ranges.h"
#include "partition/communication/reduce.h"
#include "partition/surface/boundary_on_model.h"
#include "partition/surface/dealt_pieces.h"
#include "partition/surface/feature_curves.h"
#include "partition/surface/joined_patches.h"
#include "partition/surface/local_surface.h"
#include "partition/surface/vertex_flags.h"

namespace weft::partition {
namespace {

using meshing::kNoName;
using meshing::MeshData;
using meshing::PatchId;
using meshing::Point;
using meshing::VertexKind;

std::array<Point, 3> corners(const MeshData& mesh, const std::array<std::uint32_t, 3>& t) {
  return {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
}

class ShareBuilder {
 public:
  ShareBuilder(Peers& peers, BoundaryShare& boundary, const FetchPoints& points, double ridge_angle_degrees,
               std::shared_ptr<const meshing::Model> model, std::vector<std::string>& warnings)
      : peers_(peers),
        boundary_(boundary),
        points_(points),
        ridge_angle_(ridge_angle_degrees),
        model_(std::move(model)),
        warnings_(warnings) {}

  SurfaceParts build() {
    take_share();
    if (model_) on_model_.emplace(peers_, boundary_, points_, model_);
    neighbours_.emplace(peers_, boundary_, points_);
    begin(boundary_.triangles);
    share_normals();
    find_patches();
    fit_planes();
    if (model_) put_patches_on_model();
    name_triangles();
    find_curves();
    if (model_) put_curves_on_model();
    name_features();
    add_records();
    take_pieces();
    cut();
    return finish();
  }

 private:
  /// What the owner of a triangle tells others.
  struct Told {
    std::uint32_t component;  ///< over all ranks
    std::uint32_t turned;
  };
  struct ToldLater {
    PatchId patch;
    std::uint32_t turned, name;
  };

  void take_share();
  std::vector<std::uint64_t> keys_of_triangles();
  void begin(std::vector<BoundaryTriangle> own);
  void share_normals();
  void take_normals();
  void find_patches();
  std::vector<Told> tell_components(const meshing::SurfaceComponents& found, std::uint32_t first);
  std::vector<PatchComponent> components(const meshing::SurfaceComponents& found) const;
  void take_patches(const JoinedPatches& joined, const std::vector<Told>& told);
  void turn_one_sided(const JoinedPatches& joined, const std::vector<PatchId>& patches,
                      std::vector<std::uint8_t>& turned);
  template <class T>
  void refresh(std::vector<T>& of_triangles) {
    of_triangles = from_owners<T>(peers_, *local_, own_, [&](std::size_t i) {
      return of_triangles[meshing::place_in(local_->triangles, own_[i])];
    });
  }
  void find_curves();
  void fit_planes();
  void put_patches_on_model();
  void put_curves_on_model();
  std::vector<std::vector<std::uint32_t>> faces_of_patches();
  std::vector<std::vector<PatchId>> patches_at_curves();
  void name_triangles();
  void name_features();
  void take_features();
  void add_records();
  void add_vertices();
  void add_listed_vertices();
  void take_pieces();
  void name_pieces();
  void classify_pieces();
  std::vector<BoundaryTriangle> triangles_to_make();
  void cut();
  SurfaceParts finish();

  /// f(triangle here, its place in own_), ascending. Before pieces are taken.
  template <class F>
  void for_each_own(const F& f) const {
    for (std::uint32_t t = 0, i = 0; t < local_->triangles.size(); ++t)
      if (topology().ring(t) == 0) f(t, i++);
  }
  BoundaryTriangle triangle(std::uint32_t place) const;
  /// By numbers of the whole; kNone where there is none here.
  std::uint32_t feature_between(const std::array<std::uint32_t, 2>& vertices) const;
  bool alone() const { return peers_.ranks() == 1; }
  const meshing::SurfaceTopology& topology() const { return builder_->so_far(); }

  Peers& peers_;
  BoundaryShare& boundary_;
  const FetchPoints& points_;
  const double ridge_angle_;
  const std::shared_ptr<const meshing::Model> model_;  // or null
  std::vector<std::string>& warnings_;
  std::optional<BoundaryOnModel> on_model_;  // with a model
  meshing::PieceOrder order_{meshing::Box{}};
  std::optional<SurfaceNeighbours> neighbours_;
  std::vector<std::uint32_t> own_;  // triangles of the share, ascending
  std::vector<ToldLater> own_told_;

  // The share with its rings, later what pieces are made of.
  std::shared_ptr<LocalSurface> local_;
  std::optional<meshing::TopologyBuilder> builder_;

  // The same on all ranks:
  std::vector<meshing::FlatTriangle> flat_;
  std::vector<std::int32_t> patch_refs_;
  std::vector<meshing::Patch> fitted_;         // patches as the points tell, with or without a model
  std::vector<meshing::Curve> fitted_curves_;  // curves likewise
  std::vector<std::uint64_t> firsts_;          // where shares begin along the order
  DealtPieces dealt_;                          // triangles
  std::shared_ptr<meshing::SurfaceTables> tables_ = std::make_shared<meshing::SurfaceTables>();

  std::optional<FeatureCurves> curves_;
  std::vector<std::uint32_t> feature_names_;  // by feature here
  std::vector<std::uint8_t> required_;        // by patch
  // Of what pieces are made of:
  meshing::SurfaceNames names_;
  meshing::ModelClassification classification_;
  std::vector<std::array<double, 2>> feature_t_;
  std::vector<bool> turned_;
  meshing::ModelFaults faults_;
  SurfaceParts parts_;
};

/// Along the curve.
std::vector<std::uint64_t> ShareBuilder::keys_of_triangles() {
  std::vector<std::uint32_t> vertices;
  for (const BoundaryTriangle& t : boundary_.triangles)
    vertices.insert(vertices.end(), t.vertices.begin(), t.vertices.end());
  meshing::sort_unique(vertices);
  const std::vector<Point> points = points_(vertices);
  meshing::Box box;
  for (const Point& p : points) box.include(p);
  order_ = meshing::PieceOrder(common_box(peers_, box));
  std::vector<std::uint64_t> keys;
  keys.reserve(boundary_.triangles.size());
  const auto point = [&](std::uint32_t v) { return points[meshing::place_in(vertices, v)]; };
  for (const BoundaryTriangle& t : boundary_.triangles)
    keys.push_back(order_.key({point(t.vertices[0]), point(t.vertices[1]), point(t.vertices[2])}));
  return keys;
}

/// Triangles go to the owners of their ranges.
void ShareBuilder::take_share() {
  const std::vector<std::uint64_t> keys = keys_of_triangles();
  firsts_ = first_keys(peers_, keys);
  std::vector<std::vector<BoundaryTriangle>> to_each(static_cast<std::size_t>(peers_.ranks()));
  for (std::size_t i = 0; i < keys.size(); ++i)
    to_each[static_cast<std::size_t>(std::ranges::upper_bound(firsts_, keys[i]) - firsts_.begin())].push_back(
        boundary_.triangles[i]);
  meshing::release(boundary_.triangles);
  boundary_.triangles = all_to_all_joined(peers_, std::move(to_each));
  std::ranges::sort(boundary_.triangles, {}, &BoundaryTriangle::number);
  for (const BoundaryTriangle& t : boundary_.triangles) own_.push_back(t.number);
}

void ShareBuilder::begin(std::vector<BoundaryTriangle> own) {
  builder_.reset();
  local_ = std::make_shared<LocalSurface>(neighbours_->around(std::move(own)));
  builder_.emplace(local_->mesh, ridge_angle_, on_model_ ? on_model_->known(*local_) : meshing::KnownShapes{},
                   local_->rings, local_->vertices);
}

/// As it is in the share.
BoundaryTriangle ShareBuilder::triangle(std::uint32_t place) const {
  const auto& [a, b, c] = local_->mesh.triangles[place];
  const bool required = std::ranges::binary_search(local_->mesh.required_triangles, place);
  return {local_->triangles[place],
          {local_->vertices[a], local_->vertices[b], local_->vertices[c]},
          local_->mesh.triangle_refs[place],
          required};
}

/// Both orders are ascending.
std::uint32_t ShareBuilder::feature_between(const std::array<std::uint32_t, 2>& vertices) const {
  const auto place = [&](std::uint32_t number) {
    return static_cast<std::uint32_t>(meshing::place_in(local_->vertices, number));
  };
  const std::array<std::uint32_t, 2> here{place(vertices[0]), place(vertices[1])};
  const auto& features = topology().features;
  const auto found = std::ranges::lower_bound(features, here, {}, &meshing::Surface::FeatureEdge::vertices);
  return found != features.end() && found->vertices == here
             ? static_cast<std::uint32_t>(found - features.begin())
             : meshing::kNone;
}

void ShareBuilder::share_normals() {
  std::vector<meshing::FlatTriangle> mine = builder_->flat_triangles();
  for (meshing::FlatTriangle& t : mine) {
    t.triangle = local_->triangles[t.triangle];
    if (t.behind != meshing::kNone) t.behind = local_->triangles[t.behind];
  }
  flat_ = allgather_joined(peers_, mine);
  std::ranges::sort(flat_, {}, &meshing::FlatTriangle::triangle);
  lend_normals(flat_);
  take_normals();
}

void ShareBuilder::take_normals() {
  std::vector<meshing::FlatTriangle> here;
  for (meshing::FlatTriangle t : flat_) {
    const std::size_t place = meshing::place_in(local_->triangles, t.triangle);
    if (place == local_->triangles.size() || local_->triangles[place] != t.triangle) continue;
    t.triangle = static_cast<std::uint32_t>(place);
    here.push_back(t);
  }
  builder_->take_normals(here);
}

std::vector<PatchComponent> ShareBuilder::components(const meshing::SurfaceComponents& found) const {
  std::vector<PatchComponent> all;
  for (const std::uint8_t one_sided : found.one_sided) all.push_back({0, 0, 0, 0, one_sided});
  for (std::size_t t = 0; t < found.of_triangle.size(); ++t) {
    if (found.of_triangle[t] == meshing::kNone) continue;
    PatchComponent& c = all[found.of_triangle[t]];
    if (c.triangles++ == 0) c.first = local_->triangles[t], c.ref = local_->mesh.triangle_refs[t];
    c.turned += found.turned[t];
  }
  return all;
}

/// All ranks: of all triangles here; `first`: the number of this rank's first component.
std::vector<ShareBuilder::Told> ShareBuilder::tell_components(const meshing::SurfaceComponents& found,
                                                              std::uint32_t first) {
  std::vector<std::uint32_t> places;  // of own triangles here
  for (const std::uint32_t t : own_)
    places.push_back(static_cast<std::uint32_t>(meshing::place_in(local_->triangles, t)));
  return from_owners<Told>(peers_, *local_, own_, [&](std::size_t i) {
    return Told{first + found.of_triangle[places[i]], found.turned[places[i]]};
  });
}

void ShareBuilder::find_patches() {
  const meshing::SurfaceComponents& found = builder_->components();
  const Ranges numbers(peers_, found.count());
  const std::vector<Told> told =
      tell_components(found, static_cast<std::uint32_t>(numbers.first(peers_.rank())));
  std::vector<ComponentLink> links;
  for (const auto& crossing : builder_->crossings()) {
    const Told &a = told[crossing.own], &b = told[crossing.other];
    links.push_back({std::min(a.component, b.component), std::max(a.component, b.component),
                     a.turned ^ b.turned ^ static_cast<std::uint32_t>(crossing.turned)});
  }
  take_patches(join_patches(peers_, components(found), links), told);
}

/// All ranks. What is known spreads over shares in rounds.
void ShareBuilder::turn_one_sided(const JoinedPatches& joined, const std::vector<PatchId>& patches,
                                  std::vector<std::uint8_t>& turned) {
  std::vector<std::uint32_t> steps(patches.size(), meshing::kNone);
  for (std::size_t t = 0; t < patches.size(); ++t) {
    if (!joined.one_sided[patches[t].value]) continue;
    turned[t] = meshing::kUnknownTurn;
    if (local_->triangles[t] == joined.firsts[patches[t].value]) steps[t] = turned[t] = 0;
  }
  while (partition::max(peers_, std::uint8_t{builder_->find_steps(steps)}) != 0) refresh(steps);
  while (partition::max(peers_, std::uint8_t{builder_->turn_along(steps, turned)}) != 0) refresh(turned);
  std::vector<std::uint64_t> counts(2 * joined.refs.size(), 0);  // by patch: as they are, turned
  for_each_own([&](std::uint32_t t, std::uint32_t) { ++counts[2 * patches[t].value + turned[t]]; });
  counts = partition::sum(peers_, counts);
  for (std::size_t t = 0; t < patches.size(); ++t) {
    const std::uint32_t p = patches[t].value;
    if (joined.one_sided[p] && counts[2 * p + 1] > counts[2 * p]) turned[t] ^= 1;
  }
}

void ShareBuilder::take_patches(const JoinedPatches& joined, const std::vector<Told>& told) {
  std::vector<PatchId> patches;
  std::vector<std::uint8_t> turned;
  for (std::size_t t = 0; t < told.size(); ++t) {
    patches.emplace_back(joined.patch[told[t].component]);
    turned.push_back(static_cast<std::uint8_t>(told[t].turned ^ joined.turned[told[t].component]));
  }
  if (std::ranges::count(joined.one_sided, 1) > 0) turn_one_sided(joined, patches, turned);
  for_each_own([&](std::uint32_t t, std::uint32_t) {
    own_told_.push_back({patches[t], turned[t], kNoName});
  });
  patch_refs_ = joined.refs;
  builder_->take_patches(std::move(patches), std::move(turned), patch_refs_);
  builder_->classify_vertices();
}

void ShareBuilder::find_curves() {
  std::vector<OwnFeature> mine;
  for (const meshing::FoundFeature& f : builder_->own_features()) mine.push_back({f, 0});
  std::size_t f = 0;
  topology().for_each_own_feature([&](std::uint32_t feature) {
    // All triangles at an edge have patches here; names are known of own ones alone.
    mine[f++].beside_pieces = std::ranges::any_of(topology().triangles_at(feature), [&](std::uint32_t t) {
      return needs_triangles(*tables_, topology().triangle_patch[t]);
    });
  });
  curves_.emplace(peers_, mine);
  take_curves(curves_->found(), *tables_);
  fitted_curves_ = tables_->curves;
}

void ShareBuilder::fit_planes() {
  const meshing::PlaneFits fits(local_->mesh.points, topology());
  const auto extents = added(peers_, fits.extents(local_->triangles));
  const auto sums = added(peers_, fits.sums(extents));
  tables_->planes = planes_of(extents, sums);
  const auto heights = added(peers_, fits.heights(tables_->planes));
  tables_->patches = fitted_ = patches_of(patch_refs_, extents, sums, heights, tables_->planes);
}

/// All ranks: of the model, ascending.
std::vector<std::vector<std::uint32_t>> ShareBuilder::faces_of_patches() {
  std::vector<std::array<std::uint32_t, 2>> mine;  // patches, and faces of triangles in them
  for (std::size_t i = 0; i < own_told_.size(); ++i)
    if (const std::uint32_t face = on_model_->faces()[i]; face != meshing::kNoEntity)
      mine.push_back({own_told_[i].patch.value, face});
  meshing::sort_unique(mine);
  std::vector<std::vector<std::uint32_t>> faces(patch_refs_.size());
  for (const auto& [patch, face] : allgather_joined(peers_, mine)) faces[patch].push_back(face);
  for (auto& of_patch : faces) meshing::sort_unique(of_patch);
  return faces;
}

/// All ranks: see meshing::put_curves_on_model(). Who has a curve's first edge tells.
std::vector<std::vector<PatchId>> ShareBuilder::patches_at_curves() {
  std::vector<std::array<std::uint32_t, 2>> mine;  // curves, and patches there
  for (const auto& [vertices, curve] : curves_->first_edges()) {
    if (on_model_->edge_refs()[tables_->curves[curve.value].ref].entity != meshing::kNoEntity) continue;
    for (const std::uint32_t t : topology().triangles_at(feature_between(vertices)))
      mine.push_back({curve.value, topology().triangle_patch[t].value});
  }
  std::vector<std::vector<PatchId>> patches(tables_->curves.size());
  for (const auto& [curve, patch] : allgather_joined(peers_, mine)) patches[curve].emplace_back(patch);
  return patches;
}

void ShareBuilder::put_patches_on_model() {
  tables_->model = model_;
  meshing::put_patches_on_model(on_model_->triangle_refs(), faces_of_patches(), *tables_);
}

void ShareBuilder::put_curves_on_model() {
  meshing::put_curves_on_model(on_model_->edge_refs(), patches_at_curves(), curves_->found(), *tables_);
}

void ShareBuilder::name_triangles() {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;  // and places among own triangles
  for_each_own([&](std::uint32_t t, std::uint32_t i) {
    if (needs_triangles(*tables_, own_told_[i].patch))
      keys.emplace_back(order_.key(corners(local_->mesh, topology().triangles[t])), i);
  });
  std::ranges::sort(keys);
  const Ranges places(peers_, keys.size());
  dealt_ = DealtPieces(places.total(), 0, peers_.ranks());
  for (std::size_t k = 0; k < keys.size(); ++k)
    own_told_[keys[k].second].name = dealt_.name(places.first(peers_.rank()) + k);
}

void ShareBuilder::name_features() {
  tables_->curve_in_pieces = curves_asked_for(*tables_);
  for (std::size_t c = 0; c < tables_->curve_in_pieces.size(); ++c)
    tables_->curve_in_pieces[c] |= curves_->beside_pieces()[c];
  curves_->name(order_, firsts_, tables_->curve_in_pieces, dealt_.end());
  take_features();
}

/// All ranks: what is known of the features here.
void ShareBuilder::take_features() {
  const std::vector<FeatureRecord> records = curves_->between(local_->asked, local_->vertices);
  const std::size_t count = topology().features.size();
  std::vector<meshing::FeatureOnCurve> on(count);
  feature_names_.assign(count, kNoName);
  for (const FeatureRecord& record : records) {
    const std::uint32_t f = feature_between(record.vertices);
    if (f == meshing::kNone) continue;
    on[f] = record.on;
    feature_names_[f] = record.name;
  }
  builder_->take_curves(std::move(on));
}

/// A vertex is told of by the owner of its last triangle, who knows all that are there.
void ShareBuilder::add_vertices() {
  const meshing::SurfaceTopology& s = topology();
  const std::vector<std::uint8_t> flags =
      vertex_flags(local_->mesh, s.vertex_kind, s.triangle_patch, tables_->patches);
  std::vector<std::uint32_t> last(local_->mesh.points.size(), meshing::kNone);
  for (std::uint32_t t = 0; t < s.triangles.size(); ++t)
    for (const std::uint32_t v : s.triangles[t]) last[v] = t;
  for (std::uint32_t v = 0; v < last.size(); ++v) {
    if (last[v] == meshing::kNone || s.ring(last[v]) > 0) continue;
    std::uint32_t hint = kNoName;
    if (s.vertex_kind[v] == VertexKind::surface)
      hint = own_told_[meshing::place_in(own_, local_->triangles[last[v]])].name;
    else if (s.vertex_kind[v] == VertexKind::ridge)
      hint = feature_names_[s.vertex_hint[v]];
    parts_.records.vertices.push_back({local_->vertices[v], hint, s.vertex_kind[v], flags[v]});
  }
}

/// Listed vertices may be no triangle's.
void ShareBuilder::add_listed_vertices() {
  for (const ListedPoint& p : boundary_.listed_points)
    parts_.records.vertices.push_back(
        {p.vertex, kNoName, VertexKind::interior, static_cast<std::uint8_t>(meshing::kFixed | p.flags)});
}

void ShareBuilder::add_records() {
  add_vertices();
  add_listed_vertices();
  parts_.triangles.assign(patch_refs_.size(), 0);
  for_each_own([&](std::uint32_t t, std::uint32_t i) {
    const auto& [a, b, c] = local_->mesh.triangles[t];
    const PatchId patch = own_told_[i].patch;
    parts_.records.faces.push_back({{local_->vertices[a], local_->vertices[b], local_->vertices[c]}, patch});
    std::ranges::sort(parts_.records.faces.back().vertices);
    ++parts_.triangles[patch.value];
  });
  parts_.triangles = partition::sum(peers_, parts_.triangles);
  required_.assign(patch_refs_.size(), 0);
  for (const std::uint32_t t : local_->mesh.required_triangles)
    if (topology().ring(t) == 0) required_[topology().triangle_patch[t].value] = 1;
  required_ = partition::max(peers_, required_);
  topology().for_each_own_feature([&](std::uint32_t f) {
    const auto& [a, b] = topology().features[f].vertices;
    parts_.records.edges.push_back(
        {{local_->vertices[a], local_->vertices[b]}, topology().features[f].curve});
  });
}

/// All ranks: the triangles of this rank's pieces, and those at the features of its others.
std::vector<BoundaryTriangle> ShareBuilder::triangles_to_make() {
  std::vector<std::vector<BoundaryTriangle>> to_each(static_cast<std::size_t>(peers_.ranks()));
  for (std::size_t i = 0; i < own_told_.size(); ++i)
    if (const std::uint32_t name = own_told_[i].name; name != kNoName)
      to_each[dealt_.maker(name)].push_back(boundary_.triangles[i]);
  topology().for_each_own_feature([&](std::uint32_t f) {
    if (feature_names_[f] == kNoName) return;
    auto& list = to_each[curves_->dealt().maker(feature_names_[f])];
    for (const std::uint32_t t : topology().triangles_at(f)) list.push_back(triangle(t));
  });
  std::vector<BoundaryTriangle> all = all_to_all_joined(peers_, std::move(to_each));
  meshing::sort_unique(all, &BoundaryTriangle::number);
  return all;
}

/// From the share to what is to be cut.
void ShareBuilder::take_pieces() {
  if (!alone()) {
    begin(triangles_to_make());
    take_normals();
    builder_->components();
  }
  const auto told =
      from_owners<ToldLater>(peers_, *local_, own_, [&](std::size_t i) { return own_told_[i]; });
  std::vector<PatchId> patches;
  std::vector<std::uint8_t> turned;
  for (const ToldLater& t : told) {
    patches.push_back(t.patch);
    turned.push_back(static_cast<std::uint8_t>(t.turned));
    turned_.push_back(t.turned != 0);
    names_.triangles.push_back(t.name);
  }
  if (!alone()) {
    builder_->take_patches(std::move(patches), std::move(turned), patch_refs_);
    builder_->classify_vertices();
    take_features();
  }
  name_pieces();
  if (model_) classify_pieces();
  meshing::release(own_told_);
  meshing::release(local_->asked);
  neighbours_.reset();
  on_model_.reset();
  boundary_ = {};
}

void ShareBuilder::name_pieces() {
  names_.features = std::move(feature_names_);
  names_.of_triangles = dealt_.made(peers_.rank(), names_.triangles);
  names_.of_features = curves_->dealt().made(peers_.rank(), names_.features);
  curves_.reset();
}

/// What the share knows of the model, of what pieces are made of.
void ShareBuilder::classify_pieces() {
  if (!model_->has_formulas())
    classification_.parameters = from_owners<std::array<meshing::Parameters, 3>>(
        peers_, *local_, own_, [&](std::size_t i) { return on_model_->parameters()[i]; });
  classification_.nodes = on_model_->nodes(*local_);
  feature_t_ = meshing::parameters_at(topology().features, on_model_->edges(peers_, *local_));
  warnings_.insert(warnings_.end(), on_model_->warnings().begin(), on_model_->warnings().end());
  faults_ = on_model_->faults();
}

void ShareBuilder::cut() {
  meshing::SurfaceTopology topology = builder_->take();
  builder_.reset();
  auto handles = control_points(local_->mesh.points, fitted_, fitted_curves_, topology);
  const auto cutter = std::make_shared<meshing::SurfaceCutter>(
      meshing::UncutSurface{local_->mesh.points, std::move(topology), std::move(handles),
                            std::move(classification_), std::move(feature_t_), std::move(turned_)},
      std::move(names_));
  for (const auto& corner : cutter->corners())
    parts_.records.vertices.push_back({local_->vertices[corner.vertex], corner.name, VertexKind::corner, 0});
  parts_.cutter = cutter;
}

SurfaceParts ShareBuilder::finish() {
  parts_.mesh = {local_, &local_->mesh};
  parts_.geometry = std::make_shared<Geometry>(Geometry{meshing::Surface(tables_),
                                                        {required_.begin(), required_.end()},
                                                        std::vector<bool>(patch_refs_.size(), false),
                                                        faults_});
  return std::move(parts_);
}

}  // namespace

SurfaceParts build_surface_parts(Peers& peers, BoundaryShare&& boundary, const FetchPoints& points,
                                 double ridge_angle_degrees,
                                 const std::shared_ptr<const meshing::Model>& model,
                                 std::vector<std::string>& warnings) {
  return ShareBuilder(peers, boundary, points, ridge_angle_degrees, model, warnings).build();
}

}  // namespace weft::partition
