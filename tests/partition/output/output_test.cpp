// One file of many pieces: the same bytes for any ranks, those of the merged mesh; failures leave nothing.
#include "partition/output/output.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <thread>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/io/mesh_file.h"
#include "tests/meshing/io/format_support.h"
#include "tests/partition/output/piece_support.h"

namespace weft::partition::output_test {
namespace {

using meshing::bytes_of;
using meshing::expect_contains;
using meshing::InputError;
using meshing::MeshData;
using meshing::put_bytes;
using meshing::TemporaryDirectory;
namespace fs = std::filesystem;

/// Where each point of `from` is in `to`, by its coordinates.
std::vector<std::uint32_t> places_of(const MeshData& from, const MeshData& to) {
  std::map<std::array<double, 3>, std::uint32_t> places;
  for (std::uint32_t v = 0; v < to.points.size(); ++v)
    places[{to.points[v].x, to.points[v].y, to.points[v].z}] = v;
  std::vector<std::uint32_t> result;
  for (const meshing::Point& p : from.points) result.push_back(places.at({p.x, p.y, p.z}));
  return result;
}

/// Elements with their references, in numbers of the other mesh and a fixed order.
template <std::size_t N>
std::vector<std::array<std::int64_t, N + 1>> listed(const std::vector<std::array<std::uint32_t, N>>& elements,
                                                    const std::vector<std::int32_t>& refs,
                                                    const std::vector<std::uint32_t>& places) {
  std::vector<std::array<std::int64_t, N + 1>> list;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    std::array<std::int64_t, N + 1> row;
    for (std::size_t i = 0; i < N; ++i) row[i] = places[elements[e][i]];
    row[N] = refs[e];
    list.push_back(row);
  }
  std::sort(list.begin(), list.end());
  return list;
}

/// The elements of a list of indices, with their vertices in numbers of the other mesh.
template <std::size_t N>
std::vector<std::array<std::int64_t, N + 1>> marked(const std::vector<std::array<std::uint32_t, N>>& elements,
                                                    const std::vector<std::uint32_t>& marks,
                                                    const std::vector<std::uint32_t>& places) {
  std::vector<std::array<std::uint32_t, N>> of_list;
  for (const std::uint32_t e : marks) of_list.push_back(elements[e]);
  return listed(of_list, std::vector<std::int32_t>(of_list.size()), places);
}

std::vector<std::array<std::int64_t, 2>> marked_points(const std::vector<std::uint32_t>& marks,
                                                       const std::vector<std::uint32_t>& places) {
  std::vector<std::array<std::uint32_t, 1>> points;
  for (const std::uint32_t v : marks) points.push_back({v});
  return listed(points, std::vector<std::int32_t>(points.size()), places);
}

void expect_same_mesh(const MergedMesh& a, const MergedMesh& b) {
  ASSERT_EQ(a.mesh.points.size(), b.mesh.points.size());
  const std::vector<std::uint32_t> to = places_of(a.mesh, b.mesh);
  std::vector<std::uint32_t> own(to.size());
  for (std::uint32_t v = 0; v < own.size(); ++v) own[v] = v;
  for (std::size_t v = 0; v < to.size(); ++v) {
    EXPECT_EQ(a.mesh.point_refs[v], b.mesh.point_refs[to[v]]);
    EXPECT_EQ(a.log_metrics[v], b.log_metrics[to[v]]);
  }
  const MeshData &m = a.mesh, &n = b.mesh;
  EXPECT_EQ(listed(m.tets, m.tet_refs, to), listed(n.tets, n.tet_refs, own));
  EXPECT_EQ(listed(m.triangles, m.triangle_refs, to), listed(n.triangles, n.triangle_refs, own));
  EXPECT_EQ(listed(m.edges, m.edge_refs, to), listed(n.edges, n.edge_refs, own));
  EXPECT_EQ(marked(m.edges, m.ridges, to), marked(n.edges, n.ridges, own));
  EXPECT_EQ(marked(m.edges, m.required_edges, to), marked(n.edges, n.required_edges, own));
  EXPECT_EQ(marked(m.triangles, m.required_triangles, to), marked(n.triangles, n.required_triangles, own));
  EXPECT_EQ(marked_points(m.corners, to), marked_points(n.corners, own));
  EXPECT_EQ(marked_points(m.required_points, to), marked_points(n.required_points, own));
}

TEST(MergePieces, GivesBackTheMeshThatWasCut) {
  for (unsigned seed = 0; seed < 21; ++seed) {
    const CutMesh cut = random_cut(seed);
    SCOPED_TRACE(seed);
    expect_same_mesh(merge_pieces(cut.pieces), cut.whole);
  }
}

TEST(MergePieces, OfNothingIsEmpty) { EXPECT_TRUE(merge_pieces({}).mesh.points.empty()); }

/// Writes with each number of ranks, few of them writers; returns the bytes of mesh and solution, which must
/// all be the same.
std::pair<std::string, std::string> bytes_for_all_ranks(const std::vector<MeshPiece>& pieces, int version) {
  std::pair<std::string, std::string> first;
  for (const int ranks : kRankCounts) {
    const TemporaryDirectory directory;
    const auto hands = deal(pieces, ranks, static_cast<unsigned>(ranks));
    run_on_ranks(ranks, [&](Peers& peers) {
      peers.set_most_writers(1 + version % 3);
      write_pieces(peers, hands[peers.rank()], directory / "m.meshb", directory / "m.solb", {}, version);
    });
    EXPECT_EQ(directory.num_entries(), 2u);
    const std::pair bytes{bytes_of(directory / "m.meshb"), bytes_of(directory / "m.solb")};
    if (first.first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << ranks << " ranks";
  }
  return first;
}

TEST(WritePieces, BytesAreThoseOfTheMergedMeshForAnyRanks) {
  for (unsigned seed = 0; seed < 14; ++seed) {
    SCOPED_TRACE(seed);
    const CutMesh cut = random_cut(seed);
    const MergedMesh merged = merge_pieces(cut.pieces);
    const int version = static_cast<int>(seed % 5);
    const TemporaryDirectory directory;
    write_gmf_mesh(directory / "m.meshb", merged.mesh, version);
    write_gmf_solution(directory / "m.solb", meshing::solution_from_metric(merged.log_metrics), version);
    const auto [mesh, solution] = bytes_for_all_ranks(cut.pieces, version);
    EXPECT_TRUE(mesh == bytes_of(directory / "m.meshb"));
    EXPECT_TRUE(solution == bytes_of(directory / "m.solb"));
  }
}

/// Every vertex of a piece's triangles on the face that has the triangle's reference, of its edges likewise.
void put_on_model(MeshPiece& piece) {
  meshing::MeshData& m = piece.mesh;
  std::set<std::pair<std::uint32_t, std::int32_t>> on_faces, on_edges;
  for (std::size_t t = 0; t < m.triangles.size(); ++t)
    for (const std::uint32_t v : m.triangles[t]) on_faces.emplace(v, m.triangle_refs[t]);
  for (std::size_t e = 0; e < m.edges.size(); ++e)
    for (const std::uint32_t v : m.edges[e]) on_edges.emplace(v, m.edge_refs[e]);
  for (const auto& [v, id] : on_faces)
    m.association.faces.push_back({v, id, m.points[v].x, m.points[v].y, static_cast<double>(id)});
  for (const auto& [v, id] : on_edges) m.association.edges.push_back({v, id, m.points[v].z, 0.5});
  for (const std::uint32_t v : m.corners) m.association.nodes.push_back({v, 7});
}

TEST(WritePieces, WhereVerticesLieOnAModelIsWrittenOnceForAnyRanks) {
  for (unsigned seed = 0; seed < 14; ++seed) {
    SCOPED_TRACE(seed);
    CutMesh cut = random_cut(seed);
    for (MeshPiece& piece : cut.pieces) put_on_model(piece);
    const MergedMesh merged = merge_pieces(cut.pieces);
    MeshPiece whole;
    whole.mesh = merged.mesh;
    whole.mesh.association = {};
    put_on_model(whole);
    const meshing::Association &found = merged.mesh.association, &expected = whole.mesh.association;
    EXPECT_FALSE(expected.faces.empty());
    const auto sorted = [](auto records) {
      std::ranges::sort(records, {}, [](const auto& r) { return std::pair(r.vertex, r.id); });
      return records;
    };
    EXPECT_EQ(sorted(found.faces), sorted(expected.faces));
    EXPECT_EQ(sorted(found.edges), sorted(expected.edges));
    EXPECT_EQ(sorted(found.nodes), sorted(expected.nodes));
    const TemporaryDirectory directory;
    write_gmf_mesh(directory / "m.meshb", merged.mesh, 0);
    EXPECT_TRUE(bytes_for_all_ranks(cut.pieces, 0).first == bytes_of(directory / "m.meshb"));
  }
}

class WritePiecesAs : public testing::TestWithParam<std::string> {};

TEST_P(WritePiecesAs, BytesAreThoseOfTheMergedMeshForAnyRanks) {
  meshing::RefNames names;
  names.set(2, 1, "wing");
  names.set(2, 3, "far field");
  names.set(3, 1, "air");
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const CutMesh cut = random_cut(seed);
    const MergedMesh merged = merge_pieces(cut.pieces);
    const TemporaryDirectory expected;
    meshing::SolutionData fields{merged.mesh.points.size(), {}};
    if (meshing::holds_fields(GetParam())) fields = meshing::solution_from_metric(merged.log_metrics);
    meshing::write_mesh_contents(expected / GetParam(), {merged.mesh, fields, names});
    for (const int ranks : kRankCounts) {
      const TemporaryDirectory directory;
      const auto hands = deal(cut.pieces, ranks, static_cast<unsigned>(ranks));
      run_on_ranks(ranks, [&](Peers& peers) {
        if (seed > 2) peers.set_most_writers(static_cast<int>(seed) - 2);
        write_pieces(peers, hands[peers.rank()], directory / GetParam(), directory / "m.solb", {}, 0,
                     peers.rank() == 0 ? names : meshing::RefNames{});
      });
      EXPECT_EQ(directory.num_entries(), 2u);
      EXPECT_TRUE(bytes_of(directory / GetParam()) == bytes_of(expected / GetParam())) << ranks << " ranks";
    }
  }
}

TEST_P(WritePiecesAs, NothingButEmptyPiecesMakeAnEmptyMesh) {
  const TemporaryDirectory directory;
  run_on_ranks(2, [&](Peers& peers) {
    std::vector<MeshPiece> mine(1);
    mine[0].subdomain = SubdomainId(static_cast<std::uint32_t>(peers.rank()));
    write_pieces(peers, mine, directory / GetParam());
  });
  meshing::SolutionData fields;
  if (meshing::holds_fields(GetParam())) fields = meshing::solution_from_metric({});
  meshing::write_mesh_contents(directory / ("e" + GetParam()), {MeshData{}, fields, meshing::RefNames{}});
  EXPECT_TRUE(bytes_of(directory / GetParam()) == bytes_of(directory / ("e" + GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Formats, WritePiecesAs,
                         testing::Values("m.lb8.ugrid", "m.b8.ugrid", "m.lb8l.ugrid", "m.lb4.ugrid",
                                         "m.b4.ugrid", "m.vtu", "m.msh", "m.su2", "m.ugrid", "m.mesh"));

TEST(WritePieces, WhatRoundingBreaksIsRefusedByAll) {
  CutMesh cut = random_cut(3);
  for (MeshPiece& piece : cut.pieces)
    for (meshing::Point& p : piece.mesh.points) p.x += 1e12;
  const TemporaryDirectory directory;
  for (const char* issue : {"would lose its volume in the 32-bit reals", "too large for 32-bit reals"}) {
    const auto hands = deal(cut.pieces, 3, 3);
    run_on_ranks(3, [&](Peers& peers) {
      meshing::expect_contains(
          meshing::message_of([&] { write_pieces(peers, hands[peers.rank()], directory / "m.b4.ugrid"); }),
          issue);
    });
    EXPECT_EQ(directory.num_entries(), 0u);
    for (MeshPiece& piece : cut.pieces)
      for (meshing::Point& p : piece.mesh.points) p.x = 1e40;
  }
}

TEST(WritePieces, ACarriedModelIsInTheFileForAnyRanks) {
  const CutMesh cut = random_cut(3);
  MergedMesh merged = merge_pieces(cut.pieces);
  struct Case {
    bool in_words;
    std::string extension;
  };
  for (const auto& [in_words, extension] : {Case{false, "meshb"}, {true, "meshb"}, {false, "mesh"}}) {
    const std::string whole = "m." + extension, parts = "p." + extension;
    merged.mesh.association.model = {1, 2, 3, 250, 251, 252, 253};
    merged.mesh.association.model_in_words = in_words;
    const TemporaryDirectory directory;
    write_gmf_mesh(directory / whole, merged.mesh, 0);
    for (const int ranks : kRankCounts) {
      const auto hands = deal(cut.pieces, ranks, static_cast<unsigned>(ranks));
      run_on_ranks(ranks, [&](Peers& peers) {
        const meshing::Association none;
        write_pieces(peers, hands[peers.rank()], directory / parts, {},
                     peers.rank() == 0 ? merged.mesh.association : none);
      });
      EXPECT_TRUE(bytes_of(directory / parts) == bytes_of(directory / whole)) << ranks << " ranks";
    }
  }
}

TEST(WritePieces, WritesTheMeshAlone) {
  const CutMesh cut = random_cut(5);
  const TemporaryDirectory directory;
  SelfPeers alone;
  write_pieces(alone, cut.pieces, directory / "m.meshb");
  EXPECT_EQ(directory.num_entries(), 1u);
  EXPECT_EQ(meshing::read_gmf_mesh(directory / "m.meshb").tets.size(), cut.whole.mesh.tets.size());
}

TEST(WritePieces, NothingButEmptyPiecesMakeAnEmptyMesh) {
  const TemporaryDirectory directory;
  run_on_ranks(3, [&](Peers& peers) {
    std::vector<MeshPiece> mine(1);
    mine[0].subdomain = SubdomainId(static_cast<std::uint32_t>(peers.rank()));
    if (peers.rank() == 1) mine.clear();
    write_pieces(peers, mine, directory / "m.meshb", directory / "m.solb");
  });
  EXPECT_EQ(meshing::read_gmf_mesh(directory / "m.meshb").points.size(), 0u);
  EXPECT_EQ(meshing::read_gmf_solution(directory / "m.solb").num_points, 0u);
}

/// What a PiecesOutput refers to until it has written: defaults would be gone by then.
struct Beside {
  meshing::Association carried;
  meshing::RefNames names;
  PieceFields fields;
};
static_assert(!std::is_constructible_v<PiecesOutput, Peers&, std::span<const MeshPiece>, const Numbering&,
                                       const fs::path&, const fs::path&>);

TEST(PiecesOutput, IsWrittenByThreadsOfTheirOwn) {
  const CutMesh cut = random_cut(6);
  const TemporaryDirectory directory;
  for (const std::string name : {"m.meshb", "m.mesh", "m.vtu"}) {
    SelfPeers alone;
    write_pieces(alone, cut.pieces, directory / ("whole-" + name), directory / "whole.solb");
    const auto hands = deal(cut.pieces, 3);
    run_on_ranks(3, [&](Peers& peers) {
      const Numbering numbering = number_pieces(peers, hands[peers.rank()]);
      const Beside beside;
      PiecesOutput output(peers, hands[peers.rank()], numbering, directory / name, directory / "m.solb",
                          beside.carried, 0, beside.names, beside.fields);
      std::jthread([&] { output.write(); }).join();
      output.finish(peers);
    });
    EXPECT_TRUE(bytes_of(directory / name) == bytes_of(directory / ("whole-" + name))) << name;
    EXPECT_TRUE(bytes_of(directory / "m.solb") == bytes_of(directory / "whole.solb")) << name;
  }
}

TEST(PiecesOutput, LeavesNothingWhereItGoesUnfinished) {
  const CutMesh cut = random_cut(4);
  const TemporaryDirectory directory;
  put_bytes(directory / "m.meshb", "precious");
  const auto hands = deal(cut.pieces, 3);
  run_on_ranks(3, [&](Peers& peers) {
    const Numbering numbering = number_pieces(peers, hands[peers.rank()]);
    const Beside beside;
    PiecesOutput output(peers, hands[peers.rank()], numbering, directory / "m.meshb", directory / "m.solb",
                        beside.carried, 0, beside.names, beside.fields);
    output.write();
    allgather(peers, std::vector<int>{1});  // all have written
  });
  EXPECT_EQ(bytes_of(directory / "m.meshb"), "precious");
  EXPECT_EQ(directory.num_entries(), 1u);
}

/// The message with which every rank fails to write; there must be one, and only one.
std::string common_issue(const std::vector<std::vector<MeshPiece>>& hands, const fs::path& mesh,
                         const fs::path& solution, int version = 0) {
  std::mutex mutex;
  std::set<std::string> issues;
  run_on_ranks(static_cast<int>(hands.size()), [&](Peers& peers) {
    std::string issue = "none";
    peers.set_most_writers(2);
    try {
      write_pieces(peers, hands[peers.rank()], mesh, solution, {}, version);
    } catch (const InputError& error) {
      issue = error.what();
    }
    const std::lock_guard lock(mutex);
    issues.insert(issue);
  });
  EXPECT_EQ(issues.size(), 1u);
  return *issues.begin();
}

/// Root may write anywhere: the thread that creates files gives its rights up for a while.
class AsOrdinaryUser {
 public:
  AsOrdinaryUser() : changed_(::geteuid() == 0 && ::seteuid(65534) == 0) {}
  ~AsOrdinaryUser() {
    if (changed_ && ::seteuid(0) != 0) std::abort();
  }

 private:
  bool changed_;
};

TEST(WritePieces, AnUnwritableDirectoryIsReportedByAll) {
  const CutMesh cut = random_cut(4);
  for (const int ranks : kRankCounts) {
    const TemporaryDirectory directory;
    fs::permissions(directory.path(), fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read |
                                          fs::perms::others_exec);
    {
      const AsOrdinaryUser ordinary;
      expect_contains(common_issue(deal(cut.pieces, ranks), directory / "m.meshb", directory / "m.solb"),
                      "m.meshb: cannot write: Permission denied");
    }
    fs::permissions(directory.path(), fs::perms::owner_all);
    EXPECT_EQ(directory.num_entries(), 0u);
  }
}

TEST(WritePieces, AMissingDirectoryOfTheSolutionLeavesNoMesh) {
  const CutMesh cut = random_cut(4);
  for (const int ranks : kRankCounts) {
    const TemporaryDirectory directory;
    expect_contains(common_issue(deal(cut.pieces, ranks), directory / "m.meshb", directory / "no/m.solb"),
                    "m.solb: cannot write: No such file or directory");
    EXPECT_EQ(directory.num_entries(), 0u);
  }
}

/// Lets files grow to a limit only, like a disk that fills up.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit limit{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  void (*old_handler_)(int);
  rlimit old_{};
};

TEST(WritePieces, AFullDiskKeepsTheOldFileAndLeavesNothingElse) {
  const CutMesh cut = random_cut(6);
  for (const int ranks : kRankCounts) {
    const TemporaryDirectory directory;
    put_bytes(directory / "m.meshb", "precious");
    {
      const FileSizeLimit limit(1000);
      expect_contains(common_issue(deal(cut.pieces, ranks), directory / "m.meshb", directory / "m.solb"),
                      "m.meshb: cannot write: File too large");
    }
    EXPECT_EQ(bytes_of(directory / "m.meshb"), "precious");
    EXPECT_EQ(directory.num_entries(), 1u);
  }
}

TEST(WritePieces, AValueThatOneRankCannotWriteStopsAll) {
  CutMesh cut = random_cut(4);
  cut.pieces[1].mesh.points[0].x = 1e300;
  for (const int ranks : kRankCounts) {
    const TemporaryDirectory directory;
    expect_contains(common_issue(deal(cut.pieces, ranks), directory / "m.meshb", {}, 1),
                    "m.meshb: a value is too large for the 32-bit reals of GMF version 1");
    EXPECT_EQ(directory.num_entries(), 0u);
  }
}

TEST(WritePieces, PiecesThatDoNotFitAreReportedByAll) {
  const TemporaryDirectory directory;
  const auto issue = [&](const std::vector<MeshPiece>& pieces) {
    return common_issue(deal(pieces, 3), directory / "m.meshb", {});
  };
  const std::vector<MeshPiece> pieces = random_cut(4).pieces;
  std::vector<MeshPiece> damaged = pieces;
  damaged[2].ids.pop_back();
  EXPECT_EQ(issue(damaged), "subdomain 2: arrays differ in length");
  damaged = pieces;
  damaged.push_back(damaged[3]);
  EXPECT_EQ(issue(damaged), "subdomain 3: there are two pieces of it");
  damaged = pieces;
  damaged.erase(damaged.begin());
  expect_contains(issue(damaged), "is not in the lowest subdomain that should hold it");
  EXPECT_EQ(directory.num_entries(), 0u);
}

}  // namespace
}  // namespace weft::partition::output_test
