// Loops over the indices of arrays on TBB, in the caller's arena.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

namespace weft::meshing {

/// Calls visit(i) for every i in [0, n).
template <class Visit>
void for_each_index(std::size_t n, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) visit(i);
                    });
}

/// The same with a scratch object, which each task makes for itself and hands to visit(i, scratch).
template <class Scratch, class Visit>
void for_each_index_with(std::size_t n, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      Scratch scratch;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) visit(i, scratch);
                    });
}

/// The same where each visit is much work: a task each. A thread that waits within one begins no other, so no
/// more of them are under way than there are threads.
template <class Visit>
void for_each_large(std::size_t n, const Visit& visit) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, n, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
          tbb::this_task_arena::isolate([&] { visit(i); });
      },
      tbb::simple_partitioner());
}

/// The first index in [0, n) where is_bad, or n.
template <class IsBad>
std::size_t find_first(std::size_t n, const IsBad& is_bad) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, n, 1024), n,
      [&](const tbb::blocked_range<std::size_t>& range, std::size_t first) {
        for (std::size_t i = range.begin(); i < std::min(range.end(), first); ++i)
          if (is_bad(i)) return i;
        return first;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

}  // namespace weft::meshing
