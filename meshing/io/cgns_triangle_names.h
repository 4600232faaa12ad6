// What the triangles of a CGNS zone are called, kept in runs: who reads a part of them knows all names.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <vector>

namespace weft::meshing::cgns {

/// The name of each triangle is that of its section, or of the last boundary condition that has its element.
/// Names are numbers, of which the caller knows the words. Memory goes with the runs of triangles that have
/// one name and consecutive elements.
class TriangleNames {
 public:
  /// The next triangles, which are the elements from `element` on.
  void add(std::int64_t element, std::uint64_t count, std::uint32_t name) {
    if (count == 0) return;
    if (runs_.empty() || runs_.back().last() != element - 1)
      runs_.push_back({element, size_, count});
    else
      runs_.back().count += count;
    if (names_.empty() || std::prev(names_.end())->second != name)
      names_.emplace_hint(names_.end(), size_, name);
    size_ += count;
  }

  /// After the last add(): triangles among the elements from `first` to `last`.
  void rename(std::int64_t first, std::int64_t last, std::uint32_t name) {
    if (!sorted_) std::ranges::stable_sort(runs_, {}, &Run::element);
    sorted_ = true;
    auto run = std::ranges::upper_bound(runs_, first, {}, &Run::element);
    if (run != runs_.begin()) --run;
    for (; run != runs_.end() && run->element <= last; ++run) {
      const std::int64_t from = std::max(first, run->element), to = std::min(last, run->last());
      if (from <= to) assign(run->triangle_of(from), run->triangle_of(to) + 1, name);
    }
  }

  /// use(begin, end, name) for runs of triangles, in their order.
  template <class Use>
  void for_each_run(const Use& use) const {
    for (auto at = names_.begin(); at != names_.end(); ++at) {
      const auto next = std::next(at);
      use(at->first, next == names_.end() ? size_ : next->first, at->second);
    }
  }

 private:
  struct Run {
    std::int64_t element;
    std::uint64_t triangle, count;
    std::int64_t last() const { return element + static_cast<std::int64_t>(count - 1); }
    std::uint64_t triangle_of(std::int64_t e) const {
      return triangle + static_cast<std::uint64_t>(e - element);
    }
  };

  void assign(std::uint64_t begin, std::uint64_t end, std::uint32_t name) {
    if (end < size_) names_.try_emplace(end, std::prev(names_.upper_bound(end))->second);
    names_.erase(names_.lower_bound(begin), names_.lower_bound(end));
    auto after = names_.lower_bound(begin);
    if (after != names_.end() && after->second == name) after = names_.erase(after);
    if (after == names_.begin() || std::prev(after)->second != name) names_.emplace_hint(after, begin, name);
  }

  std::uint64_t size_ = 0;
  std::vector<Run> runs_;
  bool sorted_ = false;                           ///< by element; in the order of triangles before
  std::map<std::uint64_t, std::uint32_t> names_;  ///< by the first triangle of a run
};

}  // namespace weft::meshing::cgns
