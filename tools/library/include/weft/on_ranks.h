// What the command does with files on all ranks of mpirun, beside adaptation: every rank reads its share, and
// no rank holds the whole mesh where the formats allow that (what was read whole is among the warnings). All
// ranks call these functions; they start and end MPI, unless the caller has started it (without whom it is
// one call in a process). What all ranks throw alike rank 0 throws as InputError, the others as a RunError
// that is reported already. Without mpirun they work in this process.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "weft/weft.h"

namespace weft {

/// This process among those that mpirun has started, and how many there are; 0 and 1 without it.
struct PlaceOnRanks {
  int rank = 0, ranks = 1;
};
WEFT_API PlaceOnRanks place_on_ranks();

/// What every one of these functions returns.
struct DoneOnRanks {
  bool first = true;  ///< this is rank 0, which says what there is to say
  std::vector<std::string> warnings;
};

struct MetricOnRanks : DoneOnRanks {
  std::uint64_t vertices = 0;
  double complexity = 0;
};
/// Writes the metric that options ask for at the vertices of a mesh, with the boundary's curvature from the
/// CAD model of `geometry`, if it names one: the same bytes for any number of ranks, and those of
/// make_metric() but for rounding in the complexity that is sought. `threads`: of each rank; 0 means all
/// cores.
WEFT_API MetricOnRanks write_metric_on_ranks(const std::string& mesh, const MetricOptions& options,
                                             const std::string& output, const GeometryOptions& geometry = {},
                                             int threads = 1);

struct TransferOnRanks : DoneOnRanks {
  std::uint64_t vertices = 0;
  std::size_t fields = 0;
  Transfer transfer;  ///< without the values
};
/// Writes the fields of files, at the vertices of the mesh `from`, at those of the mesh `to`: the same bytes
/// for any number of ranks, and the values of interpolate() but for rounding. `threads`: of each rank; 0
/// means all cores.
WEFT_API TransferOnRanks interpolate_on_ranks(const std::string& from, const std::vector<std::string>& fields,
                                              const std::string& to, const std::string& output,
                                              TransferMethod method, int threads = 1);

struct MeasuresOnRanks : DoneOnRanks, MeshFigures {};
/// Measures the mesh of a file, in the metric that options give, if any: counts and qualities are those of
/// measure(), sums but for rounding.
WEFT_API MeasuresOnRanks measure_on_ranks(const std::string& mesh, const MetricOptions& options);

struct VerifiedOnRanks : DoneOnRanks {
  CheckReport report;
  std::optional<CheckReport> against;  ///< of the other mesh, without its problems' words
};
/// Checks the mesh of a file, and another one beside it (empty: none): what verify() says, volumes and areas
/// but for rounding.
WEFT_API VerifiedOnRanks verify_on_ranks(const std::string& mesh, const std::string& against = {},
                                         int max_problems = 20);

struct ConvertedOnRanks : DoneOnRanks {
  MeshCounts counts;
  std::vector<Dropped> dropped;
};
/// Whether convert_on_ranks() can do it: from GMF (without a CAD model), MSH, UGRID, SU2, VTK or CGNS to any
/// format of volumes, with fields of the input or in a file that all ranks read.
WEFT_API bool can_convert_on_ranks(const std::string& input, const std::string& solution,
                                   const std::string& output, const WriteOptions& options);
/// Writes a mesh in another format, with the fields of the input and of `solution` (empty: none) inside or
/// beside: the bytes of write_mesh_file(). options.pieces of 0: as many as there are ranks, at least 2.
WEFT_API ConvertedOnRanks convert_on_ranks(const std::string& input, const std::string& solution,
                                           const std::string& output, const WriteOptions& options);

}  // namespace weft
