// The plain data of weft's interface: meshes, fields, measures and counts. A part of weft/weft.h, which
// programs include; weft's own layers include this part alone.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// What the shared library exports; everything else in it is hidden.
#if defined(__GNUC__)
#define WEFT_API __attribute__((visibility("default")))
#else
#define WEFT_API
#endif

// The names that programs use are those of namespace weft, at the end of this file.
namespace weft::meshing {

/// Bad input or failed output. what() reads "FILE: ENTITY: REASON" (empty parts left out).
class WEFT_API InputError : public std::runtime_error {
 public:
  InputError(const std::string& file, const std::string& entity, const std::string& reason)
      : std::runtime_error(join(file, join(entity, reason))) {}

 private:
  static std::string join(const std::string& a, const std::string& b) { return a.empty() ? b : a + ": " + b; }
};

/// A point or a vector in space (the same thing here, as in most of this field's codes).
struct Point {
  double x = 0, y = 0, z = 0;
  double& operator[](int i) { return (&x)[i]; }
  double operator[](int i) const { return (&x)[i]; }
  friend bool operator==(const Point&, const Point&) = default;
};

/// A symmetric 3x3 tensor in GMF order: m11 m12 m22 m13 m23 m33. A metric is one that is positive definite:
/// lengths in it are counted in units of the wanted size.
struct SymTensor {
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0;
  friend bool operator==(const SymTensor&, const SymTensor&) = default;
};

/// Where vertices lie on a CAD model, as refine and EGADS record it in GMF files (keywords 40, 41, 42), and
/// the model that a file carries (126). A vertex may have several records: a corner lies on edges and faces
/// too. Ids count from 1. `last` is what the format has at the end of a row; refine repeats the id there.
struct Association {
  struct OnNode {
    std::uint32_t vertex = 0;
    std::int32_t id = 0;
    friend bool operator==(const OnNode&, const OnNode&) = default;
  };
  struct OnEdge {
    std::uint32_t vertex = 0;
    std::int32_t id = 0;
    double t = 0, last = 0;
    friend bool operator==(const OnEdge&, const OnEdge&) = default;
  };
  struct OnFace {
    std::uint32_t vertex = 0;
    std::int32_t id = 0;
    double u = 0, v = 0, last = 0;
    friend bool operator==(const OnFace&, const OnFace&) = default;
  };
  std::vector<OnNode> nodes;
  std::vector<OnEdge> edges;
  std::vector<OnFace> faces;
  std::vector<std::uint8_t> model;  ///< bytes of a model file, such as .egads
  bool model_in_words = false;  ///< written as libMeshb does (length, then 4-byte words), not as refine does

  /// Whether no vertex is recorded.
  bool empty() const { return nodes.empty() && edges.empty() && faces.empty(); }
  friend bool operator==(const Association&, const Association&) = default;
};

/// A tetrahedral mesh as read from or written to a file. Every `*_refs` array has the length of its
/// entity array. Indices are 0-based into `points`.
struct MeshData {
  std::vector<Point> points;
  std::vector<std::int32_t> point_refs;
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::int32_t> tet_refs;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::int32_t> triangle_refs;
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::int32_t> edge_refs;
  std::vector<std::uint32_t> corners;             ///< indices of points
  std::vector<std::uint32_t> required_points;     ///< indices of points
  std::vector<std::uint32_t> ridges;              ///< indices of edges
  std::vector<std::uint32_t> required_edges;      ///< indices of edges
  std::vector<std::uint32_t> required_triangles;  ///< indices of triangles
  Association association = {};                   ///< with a CAD model; mostly empty
};

/// How well a mesh lies on one face, edge or node of a CAD model.
struct ModelEntityAccount {
  enum class Kind : std::uint8_t { node, edge, face };
  Kind kind = Kind::face;
  std::int32_t id = 0;           ///< from 1, as EGADS counts
  std::uint64_t vertices = 0;    ///< that lie on it, those of its border too
  double tolerance = 0;          ///< that the model claims
  double largest = 0, mean = 0;  ///< distance of these vertices from it
  double deviation = 0;          ///< largest distance from it of a triangle's centroid or an edge's middle
  double least_normal = 1;       ///< of a face: least product of unit normals of triangle and face
  std::uint64_t turned = 0;      ///< of a face: triangles for which that is negative
};

/// What of a boundary is not as it should be on a CAD model.
struct ModelFaults {
  std::uint64_t off = 0;     ///< vertices off the model
  double largest = 0;        ///< distance of a vertex from it
  std::uint64_t turned = 0;  ///< triangles turned against it
};

/// How well the boundary of a mesh lies on a CAD model.
struct ModelAccount {
  std::string model, unit;                        ///< name and unit of length; empty where not known
  double scale = 1;                               ///< lengths of the model have been multiplied by this
  double size = 0;                                ///< diagonal of the model's box
  std::uint64_t nodes = 0, edges = 0, faces = 0;  ///< of the model
  std::uint64_t vertices = 0, triangles = 0;      ///< of the boundary, on the model
  std::uint64_t unclassified_triangles = 0;       ///< on the reconstructed surface instead
  std::uint64_t off = 0;                          ///< vertices off the model
  std::vector<std::uint32_t> listed;              ///< some of these, 0-based, farthest first
  double largest = 0, mean = 0, deviation = 0, least_normal = 1;  ///< over all entities
  std::uint64_t turned = 0;                  ///< triangles whose normals are against the model's
  double tolerance = 0;                      ///< a vertex is off the model beyond this or its entity's
  std::vector<ModelEntityAccount> entities;  ///< nodes, edges, faces, those without vertices left out
  ModelFaults input;                         ///< of a result: those of the mesh that it was made from
};

/// One field of a solution file: `values` holds components(kind) doubles per vertex, row after row.
/// A symmetric tensor is stored as m11 m12 m22 m13 m23 m33.
struct Field {
  enum class Kind { scalar = 1, vector = 2, tensor = 3 };
  Kind kind = Kind::scalar;
  std::vector<double> values;
  std::string name;  ///< from formats that have names; empty in GMF
};

inline int components(Field::Kind kind) {
  return kind == Field::Kind::scalar ? 1 : kind == Field::Kind::vector ? 3 : 6;
}

/// The fields at the vertices of one mesh.
struct SolutionData {
  std::size_t num_points = 0;
  std::vector<Field> fields;
};

/// The names that a file gives to references, such as "wing" to reference 3 of its triangles.
class WEFT_API RefNames {
 public:
  struct Key {
    int dimension;  ///< of the entities: 1 edges, 2 triangles, 3 tets
    std::int32_t ref;
    auto operator<=>(const Key&) const = default;
  };

  bool empty() const { return names_.empty(); }
  const std::map<Key, std::string>& all() const { return names_; }
  void set(int dimension, std::int32_t ref, std::string name) { names_[{dimension, ref}] = std::move(name); }
  /// The name, or "ref_N" for a reference without one; on one line and never empty.
  std::string name(int dimension, std::int32_t ref) const;

 private:
  std::map<Key, std::string> names_;
};

/// Something that found no place where it should have gone.
struct Dropped {
  std::string what;         ///< in the plural
  std::uint64_t count = 0;  ///< 0: not countable
};

/// How to write, where a format leaves a choice; formats without it ignore it.
struct WriteOptions {
  enum class Encoding { binary, ascii, big_endian };
  Encoding encoding = Encoding::binary;  ///< big_endian: binary where the format has both orders (PLY)
  bool compress = false;                 ///< VTU: arrays go through zlib
  int gmsh_version = 4;                  ///< 4 means MSH 4.1, 2 means MSH 2.2
  int pieces = 2;                        ///< of a .pvtu
};

/// How derivatives are recovered from values at vertices.
enum class HessianRecovery {
  /// A quadratic through the vertex, fitted by least squares to the vertices within two edges (more where
  /// these do not determine it): exact for quadratic fields, at the boundary too ("k-exact", Barth 1993).
  least_squares,
  /// Gradients of the tets averaged at vertices (the lumped L2 projection), twice; Hessians at boundary
  /// vertices are means of the nearest inside, because one-sided averages are wrong there by their own size.
  /// Smoother and cheaper.
  double_projection,
};

struct MultiscaleOptions {
  HessianRecovery recovery = HessianRecovery::least_squares;
  /// p of the Lp norm in which the interpolation error is least; 1 and more, or infinity. The smaller, the
  /// more weak features count beside strong ones.
  double norm = 2;
};

/// In which space sizes grow (Alauzet 2010). Going from p to q, d the Euclidean length of the
/// edge, l its length in M_p and lambda_i the eigenvalues of M_p, M_q must be at least as fine as M_p with
enum class GradationSpace {
  /// all eigenvalues over (1 + l ln beta)^2: the anisotropy stays;
  metric,
  /// lambda_i over the square of (1 + sqrt(lambda_i) d ln beta)^t (1 + l ln beta)^(1-t), t = 1/8: between the
  /// metric space and the physical one, where the metric becomes isotropic with distance.
  mixed,
};

struct MetricLimits {
  double hmin = 0, hmax = 0;  ///< smallest and largest size; 0: none
  double aspect = 0;          ///< largest ratio of two sizes at one vertex, 1: isotropic; 0: none
  double gradation = 0;       ///< largest growth of sizes per unit edge; values <= 1: no gradation
  GradationSpace space = GradationSpace::metric;
};

/// Edges of the boundary sharper than this are features, unless options say otherwise. Degrees.
inline constexpr double kRidgeAngle = 45;

struct CurvatureOptions {
  double per_turn = 0;  ///< edges per full turn of curvature; 0: no limit
  double sagitta = 0;   ///< largest distance of an edge's middle from the surface; 0: any
  double ridge_angle_degrees = kRidgeAngle;  ///< edges sharper than this separate surfaces
};

struct WallOptions {
  std::vector<std::int32_t> refs;  ///< references of the walls' triangles
  double height = 0;               ///< wanted size across the wall, at the wall
  double growth = 1.2;             ///< ratio of the heights of successive layers, 1 and more
  double tangential = 0;           ///< wanted size along the wall, 0: any
};

/// Counts in equal intervals of [lo, hi] (of log10 of the value where `logarithmic`); outside values go
/// into `below` and `above`, the value hi into the last interval.
struct Histogram {
  double lo = 0, hi = 1;
  bool logarithmic = false;
  std::vector<std::uint64_t> counts;
  std::uint64_t below = 0, above = 0;

  void add(double value);
  /// Adds the counts of a histogram of the same intervals.
  Histogram& operator+=(const Histogram& other);
};

struct Measures {
  std::uint64_t num_vertices = 0, num_tets = 0, num_edges = 0, num_triangles = 0;
  double volume = 0;
  double complexity = 0;  ///< sum over vertices of sqrt(det M) times a quarter of the volumes of its tets
  // Mean ratio of the tets, in the log-Euclidean mean of the four vertices' metrics.
  double quality_mean = 0, quality_min = 0, quality_q01 = 0,
         quality_q001 = 0;  ///< q01: 1 % quantile, q001: 0.1 %
  double quality_below_01 = 0, quality_below_02 = 0, quality_above_08 = 0;  ///< shares
  // Edge lengths in the metric, each edge once.
  double length_mean = 0, length_min = 0, length_max = 0;
  double edges_unit = 0, edges_short = 0, edges_long = 0;  ///< shares; unit: [1/sqrt 2, sqrt 2]
  Histogram quality{0, 1, false, std::vector<std::uint64_t>(100), 0, 0};
  Histogram quality_log{-4, 0, true, std::vector<std::uint64_t>(80), 0, 0};
  Histogram length{0, 4, false, std::vector<std::uint64_t>(80), 0, 0};
  Histogram length_log{-1.5, 1.5, true, std::vector<std::uint64_t>(60), 0, 0};
};

/// How a mesh fits its metric where it was left as it is. Edges are counted as tets have them, six each.
struct MetricFit {
  double edges_long = 0, edges_short = 0;  ///< shares: longer than sqrt 2, shorter than 1/sqrt 2
  double quality_mean = 0;                 ///< mean ratio
  double tets_of_complexity = 0;           ///< for a unit of the metric's complexity
};

/// Shapes of the tets as they are, without a metric.
struct ShapeMeasures {
  double quality_mean = 0, quality_min = 0, quality_q01 = 0;  ///< mean ratio; q01: 1 % quantile
  double least_dihedral_degrees = 0;                          ///< smallest angle between two faces of a tet
};

/// What check_mesh found. `problems` holds at most `max_problems` sentences naming the entities (1-based, as
/// in files), in an order that does not depend on the number of threads.
struct CheckReport {
  std::vector<std::string> problems;
  std::uint64_t num_problems = 0;
  std::uint64_t num_components = 0;              ///< of tets connected through faces
  double volume = 0;                             ///< of all tets
  std::map<std::int32_t, double> volume_by_ref;  ///< tet reference -> volume
  std::map<std::int32_t, double> area_by_ref;    ///< triangle reference -> area
  std::uint64_t unreferenced_points = 0;         ///< points of no tet; not a problem, only counted
  /// Where the body touches itself: edges with more than two boundary faces, and how many sets of tets,
  /// joined through faces, the vertices have beyond one each. A mesh may be given like that, but adaptation
  /// must not add any: a difference from the input is a defect.
  std::uint64_t touching_edges = 0, touching_vertices = 0;
  bool ok() const { return num_problems == 0; }
};

enum class TransferMethod {
  /// Linear interpolation at the vertices: interpolate(). Exact for linear fields, never beyond the old
  /// values.
  linear,
  /// L2 projection through the common parts of both meshes' tets, then the least change that brings every
  /// value
  /// back between the smallest and the largest value that the old field takes in the tets round its vertex
  /// and that
  /// keeps the integral. Guaranteed for every component: the integral over the mesh is the old one to 1e-12
  /// of the
  /// integral of its absolute value; fields that are linear stay so where the new mesh covers the same
  /// domain; the
  /// bounds hold wherever they can. They cannot where the volumes of the meshes differ, because then a
  /// constant cannot
  /// keep both its value and its integral: what is left is added everywhere alike, and `beyond_bounds` is how
  /// much. A field of tensors that are all positive definite (a metric) stays that instead: its eigenvalues
  /// keep the bounds that the old ones had, its integral is the old one to 1e-12 of its trace's, and
  /// different volumes are made up for by a congruence (limit_tensors).
  conservative,
};

/// What became of one component of a field.
struct ComponentAccount {
  std::string name;            ///< of the field, with " 1", " 2", ... where it has several components
  double integral_before = 0;  ///< over the old mesh
  double integral_after = 0;   ///< over the new one
  double absolute = 0;         ///< the integral of the old |field| by lumped masses: the scale of both
  // The new field interpolated back to the old vertices, less the old field: over the old mesh.
  double difference_l2 = 0, norm_l2 = 0;    ///< root of the integral of the square; the old field's own
  double difference_max = 0, norm_max = 0;  ///< largest absolute value; the old field's own
  double beyond_bounds = 0;                 ///< conservative: see there
  bool stays_definite = false;              ///< conservative: of a field of positive definite tensors
};

struct Transfer {
  SolutionData fields;        ///< at the vertices of the new mesh, of the same kinds and names
  std::uint64_t outside = 0;  ///< vertices outside the old mesh; they read its closest point
  double farthest = 0;        ///< largest distance of one of them from it
  std::vector<ComponentAccount> accounts;
  TransferMethod method = TransferMethod::linear;  ///< as asked for, but linear where that was interrupted
};

enum class Verdict : std::uint8_t {
  accepted,
  not_needed,             ///< the entity is fine as it is
  inverts,                ///< a tet would not be exactly POSITIVE
  worsens_quality,        ///< the worst tet would be worse
  too_long,               ///< an edge longer than allowed would appear
  too_short,              ///< an edge shorter than allowed would appear
  breaks_topology,        ///< the link condition fails or an entity would exist twice
  breaks_classification,  ///< a corner, ridge, patch or material interface would be lost
  leaves_surface,         ///< the boundary would deviate more than hausd, or fold
  required,               ///< a required entity would change
  frozen,                 ///< what lies outside this mesh might change, or a frozen vertex would
  conflict,               ///< another thread holds a vertex: rolled back, tried again later
  too_large,              ///< the cavity exceeds the kernel's limits
  count_
};

inline constexpr std::array<std::string_view, static_cast<std::size_t>(Verdict::count_)> kVerdictNames = {
    "accepted",       "not_needed", "inverts",         "worsens_quality",
    "too_long",       "too_short",  "breaks_topology", "breaks_classification",
    "leaves_surface", "required",   "frozen",          "conflict",
    "too_large"};

enum class Operator : std::uint8_t { collapse, split, swap_edge, swap_face, smooth, relocate, count_ };

inline constexpr std::array<std::string_view, static_cast<std::size_t>(Operator::count_)> kOperatorNames = {
    "collapse", "split", "swap_edge", "swap_face", "smooth", "relocate"};

/// What an adaptation may do to a mesh. What is ruled out is done nowhere; the result is valid, and conforms
/// to the metric as well as the rest can make it.
struct AllowedOperations {
  bool insert = true;  ///< split and collapse edges: else all vertices of the input stay, and no other comes
  bool swap = true;    ///< edges and faces
  bool move = true;    ///< vertices
};

/// How often each operator came to each verdict.
struct OperationCounts {
  std::array<std::array<std::uint64_t, static_cast<std::size_t>(Verdict::count_)>,
             static_cast<std::size_t>(Operator::count_)>
      of{};
  void add(Operator op, Verdict v) { ++of[static_cast<std::size_t>(op)][static_cast<std::size_t>(v)]; }
  std::uint64_t operator()(Operator op, Verdict v) const {
    return of[static_cast<std::size_t>(op)][static_cast<std::size_t>(v)];
  }
  OperationCounts& operator+=(const OperationCounts& o) {
    for (std::size_t i = 0; i < of.size(); ++i)
      for (std::size_t j = 0; j < of[i].size(); ++j) of[i][j] += o.of[i][j];
    return *this;
  }
};

/// Where the metric asked for longer edges than a curved boundary bears, so that it was made finer there.
struct SurfaceLimit {
  std::uint64_t vertices = 0;  ///< of the boundary, on the mesh that has the metric; 0: nowhere
  double longest = 0;          ///< how many times longer its edges were than those that hausd bears, at most
  Point where;                 ///< and where
};

/// Where the boundary contradicts the metric: edges of triangles of one reference that are too short in the
/// metric, where hausd allows none of length 1.
struct SurfaceDemand {
  std::int32_t ref = 0;
  std::uint64_t edges = 0;
  double allowed = 0;  ///< the longest edge that hausd allows, in the metric: the least of all edges
  Point where;         ///< the middle of that edge
};

/// One step of the run, for the summary.
struct StageReport {
  std::string name;
  double seconds = 0;
  std::uint64_t vertices = 0, tets = 0;  ///< after it
  OperationCounts counts;                ///< of this stage alone
};

struct BallOptions {
  Point center;
  double radius = 1, size = 0.1;
};

struct CylinderOptions {
  Point base;  ///< centre of the lower end
  double radius = 1, height = 2, size = 0.1;
};

struct DeltaWingOptions {
  double size = 0;  ///< longest edge on the wing; 0: as few triangles as there can be
};

struct BoxOptions {
  std::array<std::uint32_t, 3> cells = {8, 8, 8};
  Point min = {0, 0, 0};
  Point max = {1, 1, 1};
};

}  // namespace weft::meshing

namespace weft {

using meshing::InputError;

using meshing::Point;
using Tensor = meshing::SymTensor;
using meshing::Association;
using Mesh = meshing::MeshData;
using meshing::components;
using meshing::Field;
using meshing::ModelAccount;
using meshing::ModelEntityAccount;
using Fields = meshing::SolutionData;
using meshing::Dropped;
using meshing::RefNames;
using meshing::WriteOptions;

using meshing::CurvatureOptions;
using meshing::GradationSpace;
using meshing::HessianRecovery;
using meshing::MetricLimits;
using meshing::MultiscaleOptions;
using meshing::WallOptions;

using meshing::CheckReport;
using meshing::Histogram;
using meshing::Measures;
using meshing::MetricFit;
using meshing::ShapeMeasures;
using meshing::SurfaceDemand;
using meshing::SurfaceLimit;

using meshing::ComponentAccount;
using meshing::Transfer;
using meshing::TransferMethod;

using meshing::AllowedOperations;
using meshing::kOperatorNames;
using meshing::kVerdictNames;
using meshing::OperationCounts;
using meshing::Operator;
using meshing::StageReport;
using meshing::Verdict;

using meshing::BallOptions;
using meshing::BoxOptions;
using meshing::CylinderOptions;
using meshing::DeltaWingOptions;

}  // namespace weft
