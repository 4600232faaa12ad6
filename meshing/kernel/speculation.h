// Speculation: a thread claims every vertex that an operator reads or changes, tries, never waits, and lets
// go.
#pragma once

#include <atomic>
#include <vector>

#include "meshing/kernel/tet_mesh.h"
#include "meshing/kernel/verdict.h"

namespace weft::meshing {

/// Whether operators may claim frozen vertices. `untouchable`: all around them stays as it is.
enum class FrozenPolicy : std::uint8_t { claimable, untouchable };

/// The vertices one thread holds. A claimed vertex, and every tet that contains one, is changed by nobody
/// else; so its ball can be walked and all coordinates of claimed vertices can be read.
class Claims {
 public:
  /// `owner` is unique among the threads that work on `mesh`, in 1 .. 0xFFFFFFFE. A `sole` owner works alone:
  /// it may touch all but frozen vertices, and nothing is written down. `frozen` must outlive the object and
  /// may change while it holds nothing.
  Claims(TetMesh& mesh, std::uint32_t owner, bool sole, const FrozenPolicy& frozen)
      : mesh_(mesh), owner_(owner), sole_(sole), frozen_(frozen) {
    held_.reserve(512);
  }

  /// Whether the owner is a sole one from now on. Not while any owner holds anything.
  void work_alone(bool sole) { sole_ = sole; }

  /// accepted (held now, or already), conflict, or frozen (FrozenPolicy::untouchable).
  [[gnu::always_inline]] Verdict claim(VertexId v) {
    if (sole_) return untouchable(v) ? Verdict::frozen : Verdict::accepted;
    const std::uint32_t seen = std::atomic_ref(mesh_.claim_word(v)).load(std::memory_order_relaxed);
    if (seen == owner_) return Verdict::accepted;
    if (seen != TetMesh::kFree) return Verdict::conflict;
    if (untouchable(v)) return Verdict::frozen;
    return take(v);
  }

  /// Claims a free slot in which a vertex is about to be created.
  Verdict claim_new(VertexId v) { return sole_ ? Verdict::accepted : take(v); }

  /// Claims the four vertices of a tet; conflict also when the tet changed or died meanwhile.
  Verdict claim_tet(TetId t) {
    if (!mesh_.alive(t)) return Verdict::not_needed;
    const TetVertices v = mesh_.vertices(t);
    for (VertexId x : v)
      if (const Verdict r = claim(x); r != Verdict::accepted) return r;
    return sole_ || (mesh_.alive(t) && mesh_.vertices(t) == v) ? Verdict::accepted : Verdict::conflict;
  }

  /// Not for a sole owner.
  bool holds(VertexId v) const {
    return std::atomic_ref(mesh_.claim_word(v)).load(std::memory_order_relaxed) == owner_;
  }

  /// Lets go of everything. The release order publishes what was written to the next holder.
  void release() {
    for (VertexId v : held_)
      std::atomic_ref(mesh_.claim_word(v)).store(TetMesh::kFree, std::memory_order_release);
    held_.clear();
  }

 private:
  bool untouchable(VertexId v) const { return frozen_ == FrozenPolicy::untouchable && mesh_.frozen(v); }

  [[gnu::noinline]] Verdict take(VertexId v) {
    const std::atomic_ref ref(mesh_.claim_word(v));
    std::uint32_t seen = TetMesh::kFree;
    if (!ref.compare_exchange_strong(seen, owner_, std::memory_order_acquire, std::memory_order_relaxed))
      return Verdict::conflict;
    held_.push_back(v);
    return Verdict::accepted;
  }

  TetMesh& mesh_;
  std::uint32_t owner_;
  bool sole_;
  const FrozenPolicy& frozen_;
  std::vector<VertexId> held_;
};

}  // namespace weft::meshing
