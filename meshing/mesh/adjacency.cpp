// Connectivity by bucketing: everything is filed under its smallest vertex by a counting sort, and matched
// inside the small buckets, which stay in cache. Buckets fill in any order; no result depends on that order.
#include "meshing/mesh/adjacency.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/base/filled_array.h"
#include "meshing/base/parallel.h"

namespace weft::meshing {
namespace {

using Range = tbb::blocked_range<std::size_t>;

constexpr std::size_t kVerticesPerTask = 2048;

/// The vertices of a tet, ascending, and the position in the tet that each came from.
struct SortedTet {
  Tet vertices;
  Tet positions;
  std::uint32_t odd = 0;  ///< 1 where they are an odd permutation of the tet's

  std::uint32_t code_of_face(std::size_t tet, std::size_t opposite) const {
    return static_cast<std::uint32_t>(4 * tet + positions[opposite]);
  }
  /// Two positive tets on different sides of a face have different turns of it.
  std::uint32_t turn_of_face(std::size_t opposite) const {
    return (odd ^ static_cast<std::uint32_t>(opposite)) & 1;
  }
};

inline SortedTet sorted(const Tet& tet) {
  std::array<std::uint64_t, 4> keys;
  for (std::uint64_t i = 0; i < 4; ++i) keys[i] = (std::uint64_t{tet[i]} << 2) | i;
  SortedTet result;
  const auto order = [&](int i, int j) {
    const auto [low, high] = std::minmax({keys[i], keys[j]});
    result.odd ^= low != keys[i];
    keys[i] = low;
    keys[j] = high;
  };
  order(0, 1), order(2, 3), order(0, 2), order(1, 3), order(1, 2);  // the optimal network for four
  for (int i = 0; i < 4; ++i) {
    result.vertices[i] = static_cast<std::uint32_t>(keys[i] >> 2);
    result.positions[i] = static_cast<std::uint32_t>(keys[i] & 3);
  }
  return result;
}

/// One bucket of records a vertex, all in one array.
template <class Record>
struct Buckets {
  std::vector<std::size_t> ends;
  std::unique_ptr<Record[]> records;
  std::span<Record> operator[](std::size_t vertex) const {
    return {records.get() + (vertex == 0 ? 0 : ends[vertex - 1]), records.get() + ends[vertex]};
  }
};

template <class Visit>
void for_each_vertex(std::size_t num_vertices, const Visit& visit) {
  tbb::parallel_for(Range(0, num_vertices, kVerticesPerTask), [&](const Range& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) visit(v);
  });
}

void check_tets(std::span<const Tet> tets, std::size_t num_vertices) {
  constexpr std::size_t kMaxTets = (std::size_t{1} << 30) - 1;  // so that no code equals kNoNeighbour
  if (tets.size() > kMaxTets) throw InputError("", "", "more than 1073741823 tets in one mesh");
  const std::size_t bad = find_first(tets.size(), [&](std::size_t t) {
    const Tet& tet = tets[t];
    return std::max(std::max(tet[0], tet[1]), std::max(tet[2], tet[3])) >= num_vertices;
  });
  if (bad != tets.size()) throw InputError("", "tet " + std::to_string(bad + 1), "vertex out of range");
}

/// Calls visit(begin, end) for runs of tets, which do not depend on the number of threads.
constexpr std::size_t kTetsPerRun = 4096;
std::size_t number_of_runs(std::size_t num_tets) { return (num_tets + kTetsPerRun - 1) / kTetsPerRun; }
template <class Visit>
void for_each_run(std::size_t num_tets, const Visit& visit) {
  tbb::parallel_for(
      Range(0, number_of_runs(num_tets)),
      [&](const Range& range) {
        for (std::size_t run = range.begin(); run < range.end(); ++run)
          visit(run, run * kTetsPerRun, std::min(num_tets, (run + 1) * kTetsPerRun));
      },
      tbb::simple_partitioner());
}

/// Counting sort over runs of tets, in two passes: count(run, begin, end, add) calls add(vertex, number of
/// records), place(run, begin, end, put) calls put(vertex, array of records) for the same.
template <class Record, class Count, class Place>
Buckets<Record> make_buckets(std::size_t num_tets, std::size_t num_vertices, const Count& count,
                             const Place& place) {
  Buckets<Record> buckets;
  buckets.ends.assign(num_vertices, 0);
  // Relaxed: the counters only hand out distinct places; parallel_for orders the passes. One thread spares
  // itself the locked additions.
  const bool alone = tbb::this_task_arena::max_concurrency() == 1;
  const auto take = [&buckets, alone](std::uint32_t vertex, std::size_t number) {
    std::size_t& end = buckets.ends[vertex];
    return alone ? std::exchange(end, end + number)
                 : std::atomic_ref(end).fetch_add(number, std::memory_order_relaxed);
  };
  for_each_run(num_tets,
               [&](std::size_t run, std::size_t begin, std::size_t end) { count(run, begin, end, take); });
  std::size_t total = 0;
  for (std::size_t& end : buckets.ends) total += std::exchange(end, total);
  buckets.records = std::make_unique_for_overwrite<Record[]>(total);
  // Each counter starts at its bucket's begin and has moved to its end when all records are placed.
  for_each_run(num_tets, [&](std::size_t run, std::size_t begin, std::size_t end) {
    place(run, begin, end, [&](std::uint32_t vertex, const auto& records) {
      std::copy(records.begin(), records.end(), buckets.records.get() + take(vertex, records.size()));
    });
  });
  return buckets;
}

/// A face in the bucket of its smallest vertex.
struct FaceRecord {
  std::uint32_t middle, largest;
  std::uint32_t code;  ///< tet * 4 + face
  std::uint32_t turn;  ///< SortedTet::turn_of_face
  friend auto operator<=>(const FaceRecord&, const FaceRecord&) = default;
};

bool same_face(const FaceRecord& a, const FaceRecord& b) {
  return a.middle == b.middle && a.largest == b.largest;
}

/// The three others of four.
constexpr std::array<std::array<std::size_t, 3>, 4> kOthers = {{{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}};

/// Which vertices have tets of several runs. Only faces between three of those can: all others are matched
/// within their run, in cache and without records.
class SharedVertices {
 public:
  SharedVertices(std::span<const Tet> tets, std::size_t num_vertices)
      : runs_(num_vertices, kNone), shared_(num_vertices, 0) {
    for_each_run(tets.size(), [&](std::size_t run, std::size_t begin, std::size_t end) {
      for (const Tet& tet : tets.subspan(begin, end - begin))
        for (const std::uint32_t v : tet) note(v, static_cast<std::uint32_t>(run));
    });
  }

  bool has_face(const SortedTet& tet, std::size_t opposite) const {
    const auto& [a, b, c] = kOthers[opposite];
    const Tet& v = tet.vertices;
    return shared_[v[a]] & shared_[v[b]] & shared_[v[c]];
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  void note(std::uint32_t vertex, std::uint32_t run) {
    const std::atomic_ref first(runs_[vertex]);
    std::uint32_t seen = first.load(std::memory_order_relaxed);
    if (seen == run) return;
    if (seen == kNone && first.compare_exchange_strong(seen, run, std::memory_order_relaxed)) return;
    std::atomic_ref(shared_[vertex]).store(1, std::memory_order_relaxed);
  }

  std::vector<std::uint32_t> runs_;   ///< the first seen of each vertex
  std::vector<std::uint8_t> shared_;  ///< bytes, since threads write them
};

/// A face with its smallest vertex, on the way to the bucket.
struct FiledFace {
  std::uint32_t smallest;
  FaceRecord record;
};

/// Makes tets neighbours, by several threads at different faces.
class FacePairs {
 public:
  explicit FacePairs(std::size_t num_tets)
      : neighbours_(num_tets, {kNoNeighbour, kNoNeighbour, kNoNeighbour, kNoNeighbour}) {}

  /// False where the first of them has a neighbour already: three tets share the face.
  bool pair(std::uint32_t a, std::uint32_t b, bool turn_alike) {
    if (neighbours_[a / 4][a % 4] != kNoNeighbour) return false;
    neighbours_[a / 4][a % 4] = b;
    neighbours_[b / 4][b % 4] = a;
    if (turn_alike) turns_differ_.store(false, std::memory_order_relaxed);
    return true;
  }
  Adjacency take() { return {std::move(neighbours_), turns_differ_}; }

 private:
  std::vector<Tet> neighbours_;
  std::atomic<bool> turns_differ_{true};
};

/// Pairs the equal faces of one run, or of many buckets one after the other, through a small hash table.
class FaceMatcher {
 public:
  explicit FaceMatcher(FacePairs& pairs) : pairs_(pairs) {}

  /// Of a bucket. False when three records are the same face.
  bool match(std::span<const FaceRecord> faces) {
    slots_.assign(std::bit_ceil(2 * faces.size()), 0);
    address_by(slots_.size());
    for (const FaceRecord& face : faces) {
      std::size_t slot = place(face.middle, face.largest, 0);
      while (slots_[slot] && !same_face(faces[slots_[slot] - 1], face)) slot = (slot + 1) & mask_;
      if (!slots_[slot]) {
        slots_[slot] = static_cast<std::uint32_t>(&face - faces.data()) + 1;
        continue;
      }
      const FaceRecord& other = faces[slots_[slot] - 1];
      if (!pairs_.pair(other.code, face.code, other.turn == face.turn)) return false;
    }
    return true;
  }

  /// Of the run that begins with tet `begin`: faces that no other run can have; the rest is added to `left`.
  /// Calls overused(smallest vertex) where three tets share one.
  template <class Overused>
  void match_run(std::span<const Tet> run, std::size_t begin, const SharedVertices& shared,
                 std::vector<FiledFace>& left, const Overused& overused) {
    known_.assign(std::bit_ceil(4 * run.size()), KnownFace{});
    address_by(known_.size());
    for (std::size_t t = 0; t < run.size(); ++t) {
      const SortedTet tet = sorted(run[t]);
      const auto match = [&](auto opposite) {
        constexpr auto others = kOthers[opposite];
        const Tet& v = tet.vertices;
        const Triangle face = {v[others[0]], v[others[1]], v[others[2]]};
        const std::uint32_t turn = tet.turn_of_face(opposite);
        if (shared.has_face(tet, opposite))
          left.push_back({face[0], {face[1], face[2], tet.code_of_face(begin + t, opposite), turn}});
        else if (!match_face(face, 2 * tet.code_of_face(t, opposite) + turn, 4 * begin))
          overused(face[0]);
      };
      match(std::integral_constant<std::size_t, 0>{}), match(std::integral_constant<std::size_t, 1>{});
      match(std::integral_constant<std::size_t, 2>{}), match(std::integral_constant<std::size_t, 3>{});
    }
  }

 private:
  /// A face met in a run: its vertices, ascending, and of the tet there twice the code plus the turn, as if
  /// the run began with tet 0; plus 1, 0 where none is.
  struct KnownFace {
    Triangle vertices{};
    std::uint32_t side_plus_1 = 0;
  };

  void address_by(std::size_t slots) {
    mask_ = slots - 1;
    shift_ = 64 - std::bit_width(mask_);
  }
  std::size_t place(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const std::uint64_t key = (std::uint64_t{a} << 32 | b) * 0x9E3779B97F4A7C15u + c;
    return mask_ == 0 ? 0 : key * 0xBF58476D1CE4E5B9u >> shift_;
  }

  bool match_face(const Triangle& face, std::uint32_t side, std::size_t first_code) {
    for (std::size_t slot = place(face[0], face[1], face[2]);; slot = (slot + 1) & mask_) {
      KnownFace& known = known_[slot];
      if (known.side_plus_1 == 0) {
        known = {face, side + 1};
        return true;
      }
      // In line: GCC makes a call of the arrays' comparison.
      const Triangle& v = known.vertices;
      if (((v[0] ^ face[0]) | (v[1] ^ face[1]) | (v[2] ^ face[2])) != 0) continue;
      const std::uint32_t other = known.side_plus_1 - 1;
      const auto code = [&](std::uint32_t s) { return static_cast<std::uint32_t>(first_code + s / 2); };
      return pairs_.pair(code(other), code(side), other % 2 == side % 2);
    }
  }

  FacePairs& pairs_;
  std::vector<std::uint32_t> slots_;  ///< of a bucket: indices of its records, plus 1
  std::vector<KnownFace> known_;      ///< of a run
  std::size_t mask_ = 0;
  int shift_ = 0;
};

void atomic_min(std::uint32_t& target, std::uint32_t value) {
  std::atomic_ref ref(target);
  std::uint32_t seen = ref.load(std::memory_order_relaxed);
  while (value < seen && !ref.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
  }
}

/// Sorts the faces, so that the one and the tets named do not depend on threads.
[[noreturn]] void throw_overused_face(std::uint32_t smallest, std::span<const Tet> tets) {
  std::vector<FaceRecord> faces;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const SortedTet tet = sorted(tets[t]);
    for (std::size_t i = 0; i < 4; ++i)
      if (const auto& [a, b, c] = kOthers[i]; tet.vertices[a] == smallest)
        faces.push_back({tet.vertices[b], tet.vertices[c], tet.code_of_face(t, i), tet.turn_of_face(i)});
  }
  std::sort(faces.begin(), faces.end());
  std::size_t i = 0;
  while (!same_face(faces[i], faces[i + 2])) ++i;
  const auto tet = [&](std::size_t k) { return std::to_string(faces[k].code / 4 + 1); };
  throw InputError("", "tets " + tet(i) + ", " + tet(i + 1) + " and " + tet(i + 2),
                   "share the face (" + std::to_string(smallest + 1) + " " +
                       std::to_string(faces[i].middle + 1) + " " + std::to_string(faces[i].largest + 1) +
                       ")");
}

/// Triangles in the order of their smallest vertex, then of the other two.
struct TriangleRecord {
  std::uint32_t smallest, middle, largest, index;
  friend auto operator<=>(const TriangleRecord&, const TriangleRecord&) = default;
};

std::vector<TriangleRecord> sorted_triangles(std::span<const Triangle> triangles) {
  std::vector<TriangleRecord> records(triangles.size());
  for (std::uint32_t i = 0; i < records.size(); ++i) {
    Triangle v = triangles[i];
    std::sort(v.begin(), v.end());
    records[i] = {v[0], v[1], v[2], i};
  }
  tbb::parallel_sort(records);
  return records;
}

/// The edges met last, most of them: tets that share one mostly follow each other closely.
class RecentEdges {
 public:
  /// False when the edge is among them.
  bool insert(std::uint32_t smaller, std::uint32_t larger) {
    const std::uint64_t edge = std::uint64_t{smaller} << 32 | larger;
    return std::exchange(edges_[edge * 0x9E3779B97F4A7C15u >> (64 - kBits)], edge) != edge;
  }

 private:
  static constexpr int kBits = 12;
  std::vector<std::uint64_t> edges_ = std::vector<std::uint64_t>(1 << kBits, ~std::uint64_t{0});
};

}  // namespace

Adjacency build_adjacency(std::span<const Tet> tets, std::size_t num_vertices) {
  check_tets(tets, num_vertices);
  FacePairs pairs(tets.size());
  std::uint32_t overused = kNoNeighbour;  // smallest vertex with a face in three tets
  const auto note_overused = [&overused](std::uint32_t vertex) { atomic_min(overused, vertex); };
  std::vector<std::vector<FiledFace>> left(number_of_runs(tets.size()));
  {
    const SharedVertices shared(tets, num_vertices);
    for_each_run(tets.size(), [&](std::size_t run, std::size_t begin, std::size_t end) {
      FaceMatcher(pairs).match_run(tets.subspan(begin, end - begin), begin, shared, left[run], note_overused);
    });
  }
  const auto count = [&](std::size_t run, std::size_t, std::size_t, const auto& add) {
    for (const FiledFace& face : left[run]) add(face.smallest, 1);
  };
  const auto place = [&](std::size_t run, std::size_t, std::size_t, const auto& put) {
    for (const auto& [smallest, record] : std::exchange(left[run], {}))
      put(smallest, std::array<FaceRecord, 1>{record});
  };
  const auto buckets = make_buckets<FaceRecord>(tets.size(), num_vertices, count, place);
  tbb::parallel_for(Range(0, num_vertices, kVerticesPerTask), [&](const Range& range) {
    FaceMatcher matcher(pairs);
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if (!matcher.match(buckets[v])) note_overused(static_cast<std::uint32_t>(v));
  });
  if (overused != kNoNeighbour) throw_overused_face(overused, tets);
  return pairs.take();
}

std::vector<std::uint32_t> match_triangles(std::span<const Triangle> triangles, std::span<const Tet> tets,
                                           std::size_t num_vertices) {
  check_tets(tets, num_vertices);
  const std::vector<TriangleRecord> records = sorted_triangles(triangles);
  std::vector<std::uint32_t> begins(num_vertices + 1, 0);  // of each smallest vertex in `records`
  for (const TriangleRecord& record : records) {
    if (record.largest >= num_vertices)
      throw InputError("", "triangle " + std::to_string(record.index + 1), "vertex out of range");
    ++begins[record.smallest + 1];
  }
  for (std::size_t v = 0; v < num_vertices; ++v) begins[v + 1] += begins[v];

  std::vector<std::uint32_t> codes(triangles.size(), kNoNeighbour);
  const auto look_up = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t code) {
    const auto end = records.begin() + begins[a + 1];
    auto it = std::lower_bound(records.begin() + begins[a], end, TriangleRecord{a, b, c, 0});
    for (; it != end && it->middle == b && it->largest == c; ++it) atomic_min(codes[it->index], code);
  };
  std::vector<std::uint8_t> has_triangle(num_vertices, 0);
  for (const Triangle& triangle : triangles)
    for (const std::uint32_t v : triangle) has_triangle[v] = 1;
  for_each_run(tets.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Tet& tet = tets[t];
      if (has_triangle[tet[0]] + has_triangle[tet[1]] + has_triangle[tet[2]] + has_triangle[tet[3]] < 3)
        continue;
      const SortedTet ordered = sorted(tet);
      const Tet& v = ordered.vertices;
      for (std::size_t i = 0; i < 4; ++i)
        if (const auto& [a, b, c] = kOthers[i]; begins[v[a]] != begins[v[a] + 1])
          look_up(v[a], v[b], v[c], ordered.code_of_face(t, i));
    }
  });
  return codes;
}

EdgeLists unique_edges(std::span<const Tet> tets, std::size_t num_vertices) {
  check_tets(tets, num_vertices);
  // What the first pass finds in a run is kept for the second.
  using Edge = std::array<std::uint32_t, 2>;
  std::vector<std::vector<Edge>> found(number_of_runs(tets.size()));
  const auto count = [&](std::size_t run, std::size_t begin, std::size_t end, const auto& add) {
    RecentEdges recent;
    FilledArray<Edge> edges;
    edges.make_room(2 * (end - begin));  // a mesh in good order has fewer
    for (const Tet& tet : tets.subspan(begin, end - begin)) {
      edges.make_room(6);
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j) {
          const auto [a, b] = std::minmax(tet[i], tet[j]);
          edges.push_if(recent.insert(a, b), {a, b});
        }
    }
    for (const auto& [a, b] : edges) add(a, 1);
    found[run].assign(edges.begin(), edges.end());
  };
  const auto place = [&](std::size_t run, std::size_t, std::size_t, const auto& put) {
    for (const auto& [a, b] : std::exchange(found[run], {})) put(a, std::array<std::uint32_t, 1>{b});
  };
  const auto buckets = make_buckets<std::uint32_t>(tets.size(), num_vertices, count, place);
  EdgeLists edges{std::vector<std::size_t>(num_vertices + 1, 0), {}};
  for_each_vertex(num_vertices, [&](std::size_t v) {
    const std::span<std::uint32_t> others = buckets[v];
    std::sort(others.begin(), others.end());
    edges.begins[v + 1] = std::unique(others.begin(), others.end()) - others.begin();
  });
  for (std::size_t v = 0; v < num_vertices; ++v) edges.begins[v + 1] += edges.begins[v];
  edges.others.resize(edges.begins.back());
  for_each_vertex(num_vertices, [&](std::size_t v) {
    std::copy_n(buckets[v].begin(), edges.begins[v + 1] - edges.begins[v],
                edges.others.begin() + edges.begins[v]);
  });
  return edges;
}

VertexLists vertex_neighbours(std::span<const Tet> tets, std::size_t num_vertices) {
  const EdgeLists edges = unique_edges(tets, num_vertices);
  VertexLists lists{std::vector<std::size_t>(num_vertices + 1, 0), {}};
  const auto for_each_edge = [&](const auto& visit) {
    for (std::uint32_t v = 0; v < num_vertices; ++v)
      for (const std::uint32_t w : edges.of(v)) visit(v, w);
  };
  for_each_edge([&](std::uint32_t v, std::uint32_t w) { ++lists.begins[v + 1], ++lists.begins[w + 1]; });
  for (std::size_t v = 0; v < num_vertices; ++v) lists.begins[v + 1] += lists.begins[v];
  lists.items.resize(lists.begins.back());
  std::vector<std::size_t> next(lists.begins.begin(), lists.begins.end() - 1);
  // Ascending as they are: v's smaller neighbours were visited before v, in their order, and put themselves
  // here.
  for_each_edge([&](std::uint32_t v, std::uint32_t w) {
    lists.items[next[v]++] = w;
    lists.items[next[w]++] = v;
  });
  return lists;
}

VertexLists vertex_tets(std::span<const Tet> tets, std::size_t num_vertices) {
  check_tets(tets, num_vertices);
  VertexLists lists{std::vector<std::size_t>(num_vertices + 1, 0), {}};
  for (const Tet& tet : tets)
    for (const std::uint32_t v : tet) ++lists.begins[v + 1];
  for (std::size_t v = 0; v < num_vertices; ++v) lists.begins[v + 1] += lists.begins[v];
  lists.items.resize(lists.begins.back());
  std::vector<std::size_t> next(lists.begins.begin(), lists.begins.end() - 1);
  for (std::uint32_t t = 0; t < tets.size(); ++t)
    for (const std::uint32_t v : tets[t]) lists.items[next[v]++] = t;
  return lists;
}

}  // namespace weft::meshing
