// The kernel's mesh: structure of arrays of plain data, growing without moving, written by
// several threads under claims (speculation.h).
#pragma once

#include <tbb/concurrent_hash_map.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/base/stable_array.h"
#include "meshing/geometry/surface/vertex_kind.h"
#include "meshing/mesh/tet_tables.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// One face of one tet, packed: 4 * tet + face. Invalid: beyond the boundary.
struct TetFace {
  std::uint32_t code = 0xFFFFFFFFu;
  TetFace() = default;
  explicit TetFace(std::uint32_t c) : code(c) {}
  TetFace(TetId t, int face) : code(4 * t.value + static_cast<std::uint32_t>(face)) {}
  bool valid() const { return code != 0xFFFFFFFFu; }
  TetId tet() const { return TetId(code >> 2); }
  int face() const { return static_cast<int>(code & 3u); }
  friend bool operator==(TetFace, TetFace) = default;
};

using TetVertices = std::array<VertexId, 4>;

/// Work marks: what has to be looked at again. Set by whoever changes something, cleared by the sweep.
/// kLongLater: has an edge to be split at a finer level. kFresh: not yet examined. kRefusedEdge: three bits,
/// see TetMesh::refused_edge.
enum TetMark : std::uint8_t {
  kCheckLong = 1,
  kCheckSwap = 2,
  kCheckPoor = 4,
  kAllTetMarks = 7,
  kLongLater = 8,
  kFresh = 16,
  kRefusedEdge = 32 + 64 + 128
};
/// kHasShort remembers a short edge that could not be collapsed: it is tried again when something around it
/// changes. kStuck: neither a better place nor a collapse improves the worst tet of its ball, until something
/// there changes.
enum VertexMark : std::uint8_t { kCheckShort = 1, kCheckPlace = 2, kHasShort = 4, kStuck = 8 };

/// What else is known of a vertex. kFixed: must stay where it is and as it is. kListed...: to be listed in
/// the output. kCaller...: not the kernel's; it carries them along and gives them to no vertex that it
/// creates.
enum VertexFlag : std::uint8_t {
  kFixed = 1,
  kListedRequired = 2,
  kListedCorner = 4,
  kOnCurved = 8,
  kFrozen = 16,
  kCallerFirst = 32,
  kCallerSecond = 64,
  kCallerThird = 128
};

/// What a mesh can have at most: TetFace is a tet times four in 32 bits.
inline constexpr std::size_t kMostTets = (1u << 30) - 1;

struct Room {
  std::size_t vertices, tets;
};

class TetMesh {
 public:
  static constexpr std::uint32_t kFree = 0;  ///< claim word of a vertex nobody holds

  /// Reserves address space (not memory) for that many entities. A small mesh does without huge pages, of
  /// which each array takes at least one. Throws NoAddressSpace; see reserve_tet_mesh.
  TetMesh(std::size_t vertex_capacity, std::size_t tet_capacity, Pages pages = Pages::huge);

  // --- sizes: slots, dead ones included ---
  std::uint32_t vertex_slots() const { return vertex_slots_.load(std::memory_order_relaxed); }
  std::uint32_t tet_slots() const { return tet_slots_.load(std::memory_order_relaxed); }
  /// Takes `count` fresh slots for the calling thread; they are dead until written. Nothing, and is_full()
  /// from then on, where there is no room.
  std::optional<std::uint32_t> try_take_vertex_slots(std::uint32_t count);
  std::optional<std::uint32_t> try_take_tet_slots(std::uint32_t count);
  /// The same for callers that know how many they need. Throws std::length_error.
  std::uint32_t take_vertex_slots(std::uint32_t count);
  std::uint32_t take_tet_slots(std::uint32_t count);
  /// Whether slots have been asked for in vain.
  bool is_full() const { return is_full_.load(std::memory_order_relaxed); }
  /// Makes room for so many entities, no fewer than there is; is_full() is over. Slots stay what they are,
  /// but places move: nobody else may be at work. Throws NoAddressSpace.
  void reserve(Room room);
  /// The same for four times what there is, or as much as the system grants. False, and nothing has changed,
  /// where that is none, or a mesh cannot have more.
  bool grow();
  std::size_t vertex_capacity() const { return vertices_.capacity(); }
  std::size_t tet_capacity() const { return tets_.capacity(); }

  // --- tets ---
  bool alive(TetId t) const { return load(tets_[t.value].v[0]) != load(tets_[t.value].v[1]); }
  /// The four vertices, readable without a claim (words never tear; they may change at once).
  TetVertices vertices(TetId t) const {
    const Tet& r = tets_[t.value];
    return {VertexId(load(r.v[0])), VertexId(load(r.v[1])), VertexId(load(r.v[2])), VertexId(load(r.v[3]))};
  }
  VertexId vertex(TetId t, int i) const { return VertexId(load(tets_[t.value].v[i])); }
  void set_vertices(TetId t, const TetVertices& v) {
    for (int i = 0; i < 4; ++i) store(tets_[t.value].v[i], v[i].value);
  }
  void set_vertex(TetId t, int i, VertexId v) { store(tets_[t.value].v[i], v.value); }
  void kill(TetId t) {
    set_vertices(t, {VertexId(0), VertexId(0), VertexId(0), VertexId(0)});
    store(marks_[t.value], std::uint8_t{0});
  }
  TetFace neighbour(TetId t, int face) const { return TetFace(load(tets_[t.value].n[face])); }
  void set_neighbour(TetId t, int face, TetFace n) { store(tets_[t.value].n[face], n.code); }
  /// Makes two faces neighbours of each other; either may be invalid.
  void glue(TetFace a, TetFace b) {
    if (a.valid()) set_neighbour(a.tet(), a.face(), b);
    if (b.valid()) set_neighbour(b.tet(), b.face(), a);
  }
  [[gnu::always_inline]] int local_index(TetId t, VertexId v) const {
    // Without branches: which of the four it is cannot be predicted.
    const Tet& r = tets_[t.value];
    return (load(r.v[0]) == v.value) + 2 * (load(r.v[1]) == v.value) + 3 * (load(r.v[2]) == v.value) +
           4 * (load(r.v[3]) == v.value) - 1;
  }
  /// The patch that a face lies on: boundary or material interface, on both its tets. Invalid inside.
  PatchId patch(TetId t, int face) const { return PatchId(patches_[t.value][face] - 1); }
  /// Where nothing changes nothing is written: pages of tets inside stay untouched, and take no memory.
  void set_patch(TetId t, int face, PatchId p) {
    std::uint32_t& stored = patches_[t.value][face];
    if (stored != p.value + 1) stored = p.value + 1;
  }
  std::int32_t ref(TetId t) const { return tet_refs_[t.value]; }
  void set_ref(TetId t, std::int32_t r) { tet_refs_[t.value] = r; }
  /// Cached mean ratio (quality.h) in the mean that operators judge by (Kernel::policy); they keep it right.
  float quality(TetId t) const { return load(quality_[t.value]); }
  void set_quality(TetId t, float q) { store(quality_[t.value], q); }
  std::uint8_t marks(TetId t) const { return load(marks_[t.value]); }
  void mark(TetId t, std::uint8_t m) {
    if (m & kCheckLong) take_bits(marks_[t.value], kRefusedEdge);
    set_bits(marks_[t.value], m);
  }
  /// Removes marks and says which of them were there.
  std::uint8_t take_marks(TetId t, std::uint8_t m) { return take_bits(marks_[t.value], m); }
  /// The edge whose split was refused last, from whichever of its tets, with all around it as it is now; -1
  /// for none. A mark kCheckLong ends it.
  int refused_edge(TetId t) const { return (marks(t) >> kRefusedEdgeShift) - 1; }
  void set_refused_edge(TetId t, int edge) {
    take_bits(marks_[t.value], kRefusedEdge);
    set_bits(marks_[t.value], static_cast<std::uint8_t>((edge + 1) << kRefusedEdgeShift));
  }

  // --- vertices ---
  bool alive(VertexId v) const { return load(vertices_[v.value].tet) != 0; }
  const Point& point(VertexId v) const { return vertices_[v.value].x; }
  const Metric& metric(VertexId v) const { return vertices_[v.value].metric; }
  const LogMetric& log_metric(VertexId v) const { return vertices_[v.value].log_metric; }
  void set_point(VertexId v, const Point& p) { vertices_[v.value].x = p; }
  void set_metric(VertexId v, const LogMetric& l, const Metric& m) {
    vertices_[v.value].log_metric = l;
    vertices_[v.value].metric = m;
  }
  TetId tet_of(VertexId v) const { return TetId(load(vertices_[v.value].tet) - 1); }
  void set_tet_of(VertexId v, TetId t) { store(vertices_[v.value].tet, t.value + 1); }
  VertexKind kind(VertexId v) const { return vertices_[v.value].kind; }
  void set_kind(VertexId v, VertexKind k) { vertices_[v.value].kind = k; }
  std::uint8_t flags(VertexId v) const { return vertices_[v.value].flags; }
  void set_flags(VertexId v, int flags) { store(vertices_[v.value].flags, static_cast<std::uint8_t>(flags)); }
  bool fixed(VertexId v) const { return flags(v) & kFixed; }
  /// True when all four lie on curved boundary: such a tet lies flat upon the surface, and when the surface
  /// is retriangulated under it the mesh may come to overlap although all its tets are positive. None is ever
  /// created.
  bool all_on_curved_boundary(const TetVertices& v) const {
    return flags(v[0]) & flags(v[1]) & flags(v[2]) & flags(v[3]) & kOnCurved;
  }
  std::int32_t ref(VertexId v) const { return vertex_refs_[v.value]; }
  void set_ref(VertexId v, std::int32_t r) { vertex_refs_[v.value] = r; }
  /// Where in the background and on the reference surface the vertex is (a start for nearby queries).
  std::uint32_t background_hint(VertexId v) const { return background_hints_[v.value]; }
  void set_background_hint(VertexId v, std::uint32_t h) { background_hints_[v.value] = h; }
  std::uint32_t surface_hint(VertexId v) const { return surface_hints_[v.value]; }
  void set_surface_hint(VertexId v, std::uint32_t h) { surface_hints_[v.value] = h; }
  /// A name that the caller gives the vertex and the kernel only carries along; 0 for one that the kernel
  /// creates.
  std::uint64_t label(VertexId v) const { return labels_[v.value]; }
  void set_label(VertexId v, std::uint64_t label) { labels_[v.value] = label; }
  std::uint8_t marks(VertexId v) const { return load(vertex_marks_[v.value]); }
  void mark(VertexId v, std::uint8_t m) { set_bits(vertex_marks_[v.value], m); }
  /// The ball of v has changed.
  void touch(VertexId v) {
    const std::uint8_t seen = marks(v);
    mark(v, seen & kHasShort ? kCheckShort | kCheckPlace : kCheckPlace);
    if (seen & kStuck) take_marks(v, kStuck);
  }
  std::uint8_t take_marks(VertexId v, std::uint8_t m) { return take_bits(vertex_marks_[v.value], m); }
  void kill(VertexId v) {
    store(vertices_[v.value].tet, 0u);
    store(vertex_marks_[v.value], std::uint8_t{0});
  }

  // --- asked for in advance, as walks wait for memory more than for anything else ---
  void prefetch(TetId t) const { __builtin_prefetch(&tets_[t.value]); }
  /// Place, kind and metric.
  void prefetch(VertexId v) const {
    const char* p = reinterpret_cast<const char*>(&vertices_[v.value]);
    __builtin_prefetch(p);
    __builtin_prefetch(p + 64);
  }

  // --- claims: see speculation.h, the only user ---
  std::uint32_t& claim_word(VertexId v) { return claims_[v.value]; }

  /// A frozen vertex may have tets that are not in this mesh. It is neither moved nor removed, and no face
  /// without neighbour whose three vertices are frozen, nor an edge of one, changes; all else around it may.
  /// Not while operators run.
  void freeze(VertexId v) { vertices_[v.value].flags |= kFrozen; }
  void thaw(VertexId v) { vertices_[v.value].flags &= static_cast<std::uint8_t>(~kFrozen); }
  /// May be asked before v is claimed: no operator freezes, thaws or removes a frozen vertex.
  bool frozen(VertexId v) const { return load(vertices_[v.value].flags) & kFrozen; }
  bool has_frozen(TetId t) const {
    const TetVertices v = vertices(t);
    return std::any_of(v.begin(), v.end(), [this](VertexId x) { return frozen(x); });
  }

  // --- feature edges ---
  /// The curve of edge (a, b), invalid when it is no feature edge. Both ends must be claimed.
  CurveId curve(VertexId a, VertexId b) const {
    if (std::min(kind(a), kind(b)) < VertexKind::ridge) return {};  // only between ridge vertices and corners
    return listed_curve(a, b);
  }
  void set_curve(VertexId a, VertexId b, CurveId c);  ///< an invalid curve erases
  /// (a, p) and (p, b) take the place of (a, b). An allocation that fails leaves (a, b).
  void divide_curve(VertexId a, VertexId p, VertexId b, CurveId c);
  struct FeatureEdge {
    VertexId a, b;
    CurveId curve;
  };
  std::vector<FeatureEdge> feature_edges() const;  ///< sorted; not while operators run

  /// Moves everything to new places: new id of each live vertex and tet (invalid for dead ones). Order of
  /// slots becomes that of the maps; dead slots vanish and their memory is returned. Not while operators run.
  void renumber(const std::vector<VertexId>& old_to_new_vertex, std::uint32_t num_vertices,
                const std::vector<TetId>& old_to_new_tet, std::uint32_t num_tets);

 private:
  struct Tet {
    std::array<std::uint32_t, 4> v, n;
  };
  struct VertexHead {
    Point x;
    std::uint32_t tet;  // of the vertex + 1, 0 for a dead vertex
    VertexKind kind;
    std::uint8_t flags;
  };
  /// What operators read of a vertex, in two neighbouring cache lines; the first has what most of them need.
  struct alignas(128) Vertex : VertexHead {
    Metric metric;
    LogMetric log_metric;
  };
  static_assert(sizeof(Vertex) == 128);
  static constexpr int kRefusedEdgeShift = 5;
  template <class T>
  static T load(const T& x) {
    return std::atomic_ref(const_cast<T&>(x)).load(std::memory_order_relaxed);
  }
  template <class T>
  static void store(T& x, T value) {
    std::atomic_ref(x).store(value, std::memory_order_relaxed);
  }
  void set_capacities(Room room);
  CurveId listed_curve(VertexId a, VertexId b) const;
  static void set_bits(std::uint8_t& x, std::uint8_t m) {
    if ((load(x) & m) != m) std::atomic_ref(x).fetch_or(m, std::memory_order_relaxed);
  }
  static std::uint8_t take_bits(std::uint8_t& x, std::uint8_t m) {
    if (!(load(x) & m)) return 0;
    return std::atomic_ref(x).fetch_and(static_cast<std::uint8_t>(~m), std::memory_order_relaxed) & m;
  }
  static std::uint64_t edge_key(VertexId a, VertexId b) {
    return a < b ? (std::uint64_t{a.value} << 32 | b.value) : (std::uint64_t{b.value} << 32 | a.value);
  }

  std::atomic<std::uint32_t> vertex_slots_{0}, tet_slots_{0};
  std::atomic<bool> is_full_{false};
  StableArray<Tet> tets_;
  StableArray<std::array<std::uint32_t, 4>> patches_;  // patch + 1, so that fresh memory means none
  StableArray<std::int32_t> tet_refs_;
  StableArray<float> quality_;
  StableArray<std::uint8_t> marks_;
  StableArray<Vertex> vertices_;
  StableArray<std::uint8_t> vertex_marks_;
  StableArray<std::int32_t> vertex_refs_;
  StableArray<std::uint64_t> labels_;
  StableArray<std::uint32_t> background_hints_, surface_hints_, claims_;
  tbb::concurrent_hash_map<std::uint64_t, std::uint32_t> curves_;
};

/// A mesh with room for so many entities, or, where the system does not grant the address space (ulimit -v,
/// strict overcommit), for half as many, a quarter and so on down to `least`. Throws NoAddressSpace.
std::unique_ptr<TetMesh> reserve_tet_mesh(Room wanted, Room least, Pages pages = Pages::huge);

}  // namespace weft::meshing
