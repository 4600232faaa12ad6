// The counters of the generated profiling layer, and which MPI functions are collective.
#include "engine/mpi/mpi_calls.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>

namespace weft::engine {

// Defined by the source that generate_mpi_calls.py writes.
namespace mpi_layer {
extern const char* const names[];
extern std::atomic<long> counts[];
extern const std::size_t size;
}  // namespace mpi_layer

std::vector<std::pair<std::string, long>> mpi_calls() {
  std::vector<std::pair<std::string, long>> calls;
  for (std::size_t i = 0; i < mpi_layer::size; ++i) {
    const long count = mpi_layer::counts[i].load(std::memory_order_relaxed);
    if (count > 0) calls.emplace_back(mpi_layer::names[i], count);
  }
  return calls;
}

namespace {

/// Data collectives (chapter 6 and 8.6). Each also has a nonblocking form, "I" before the name, and a
/// persistent one,
/// "_init" behind it.
constexpr std::array kDataCollectives = std::to_array<std::string_view>({
    "allgather",
    "allgatherv",
    "allreduce",
    "alltoall",
    "alltoallv",
    "alltoallw",
    "barrier",
    "bcast",
    "exscan",
    "gather",
    "gatherv",
    "neighbor_allgather",
    "neighbor_allgatherv",
    "neighbor_alltoall",
    "neighbor_alltoallv",
    "neighbor_alltoallw",
    "reduce",
    "reduce_scatter",
    "reduce_scatter_block",
    "scan",
    "scatter",
    "scatterv",
});

/// All other functions that some group must call together.
constexpr std::array kOtherCollectives = std::to_array<std::string_view>({
    // start and end
    "finalize",
    "init",
    "init_thread",
    "session_finalize",
    "session_init",
    // communicators and topologies
    "cart_create",
    "cart_sub",
    "comm_accept",
    "comm_connect",
    "comm_create",
    "comm_create_from_group",
    "comm_create_group",
    "comm_disconnect",
    "comm_dup",
    "comm_dup_with_info",
    "comm_free",
    "comm_idup",
    "comm_idup_with_info",
    "comm_join",
    "comm_set_info",
    "comm_spawn",
    "comm_spawn_multiple",
    "comm_split",
    "comm_split_type",
    "dist_graph_create",
    "dist_graph_create_adjacent",
    "graph_create",
    "intercomm_create",
    "intercomm_create_from_groups",
    "intercomm_merge",
    // windows
    "win_allocate",
    "win_allocate_shared",
    "win_create",
    "win_create_dynamic",
    "win_fence",
    "win_free",
    "win_set_info",
    // files
    "file_close",
    "file_iread_all",
    "file_iread_at_all",
    "file_iwrite_all",
    "file_iwrite_at_all",
    "file_open",
    "file_preallocate",
    "file_read_all",
    "file_read_all_begin",
    "file_read_all_end",
    "file_read_at_all",
    "file_read_at_all_begin",
    "file_read_at_all_end",
    "file_read_ordered",
    "file_read_ordered_begin",
    "file_read_ordered_end",
    "file_seek_shared",
    "file_set_atomicity",
    "file_set_info",
    "file_set_size",
    "file_set_view",
    "file_sync",
    "file_write_all",
    "file_write_all_begin",
    "file_write_all_end",
    "file_write_at_all",
    "file_write_at_all_begin",
    "file_write_at_all_end",
    "file_write_ordered",
    "file_write_ordered_begin",
    "file_write_ordered_end",
});

bool contains(const auto& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

bool is_collective(std::string_view mpi_function_name) {
  std::string name(mpi_function_name);
  // The standard spells names in any case for Fortran, and MPI-4 adds "_c" to those with large counts.
  std::ranges::transform(name, name.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  std::string_view rest = name;
  for (const std::string_view prefix : {"pmpi_", "mpi_", "mpix_"}) {
    if (!rest.starts_with(prefix)) continue;
    rest.remove_prefix(prefix.size());
    break;
  }
  if (rest.ends_with("_c")) rest.remove_suffix(2);
  if (contains(kOtherCollectives, rest)) return true;
  if (rest.ends_with("_init")) rest.remove_suffix(5);
  if (contains(kDataCollectives, rest)) return true;
  return rest.starts_with('i') && contains(kDataCollectives, rest.substr(1));
}

}  // namespace weft::engine
