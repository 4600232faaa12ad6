// Files of one piece each: read back they are the pieces, and together the merged mesh.
#include "partition/output/piece_files.h"

#include <gtest/gtest.h>

#include <fstream>
#include <mutex>
#include <sstream>
#include <tuple>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/io/vtk/pvtu.h"
#include "tests/meshing/io/format_support.h"
#include "tests/partition/output/piece_support.h"

namespace weft::partition::piece_files_test {
namespace {

using meshing::bytes_of;
using meshing::expect_contains;
using meshing::MeshData;
using meshing::TemporaryDirectory;
namespace fs = std::filesystem;

/// Bytes of all files of a directory by their names.
std::map<std::string, std::string> all_files(const fs::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(directory))
    files[entry.path().filename().string()] = bytes_of(entry.path());
  return files;
}

template <class Write>
void write_on(int ranks, const std::vector<MeshPiece>& pieces, const Write& write) {
  const auto hands = deal(pieces, ranks, static_cast<unsigned>(ranks));
  run_on_ranks(ranks, [&](Peers& peers) { write(peers, hands[peers.rank()]); });
}

/// Tets and triangles in any order.
template <class Elements>
Elements sorted(Elements elements) {
  std::sort(elements.begin(), elements.end());
  return elements;
}

TEST(PiecesAsVtu, TogetherAreTheMergedMesh) {
  for (unsigned seed = 0; seed < 7; ++seed) {
    SCOPED_TRACE(seed);
    const CutMesh cut = random_cut(seed);
    const MergedMesh merged = merge_pieces(cut.pieces);
    std::map<std::string, std::string> first;
    for (const int ranks : kRankCounts) {
      const TemporaryDirectory directory;
      write_on(ranks, cut.pieces, [&](Peers& peers, const auto& mine) {
        write_pieces_as_vtu(peers, mine, directory / "m.pvtu");
      });
      EXPECT_EQ(directory.num_entries(), cut.pieces.size() + 1);
      if (first.empty()) first = all_files(directory.path());
      EXPECT_TRUE(all_files(directory.path()) == first);
      const meshing::MeshContents read = meshing::read_pvtu(directory / "m.pvtu");
      EXPECT_EQ(read.mesh.points, merged.mesh.points);
      EXPECT_EQ(read.mesh.point_refs, merged.mesh.point_refs);
      EXPECT_EQ(sorted(read.mesh.tets), sorted(merged.mesh.tets));
      EXPECT_EQ(sorted(read.mesh.triangles), sorted(merged.mesh.triangles));
      EXPECT_EQ(sorted(read.mesh.edges), sorted(merged.mesh.edges));
      EXPECT_EQ(read.mesh.corners, sorted(merged.mesh.corners));
      ASSERT_EQ(read.fields.fields.size(), 1u);
      EXPECT_EQ(read.fields.fields[0].values,
                meshing::solution_from_metric(merged.log_metrics).fields[0].values);
    }
  }
}

TEST(PiecesAsVtu, SayWhatViewersShow) {
  const CutMesh cut = random_cut(3);
  const TemporaryDirectory directory;
  SelfPeers alone;
  write_pieces_as_vtu(alone, cut.pieces, directory / "m.pvtu");
  for (const std::string name : {"m.pvtu", "m_0.vtu", "m_3.vtu"})
    for (const std::string array :
         {"\"quality\"", "\"subdomain\"", "\"ref\"", "\"metric\"", "\"GlobalPointIds\""})
      expect_contains(bytes_of(directory / name), array);
}

TEST(PiecesAsVtu, AllHaveReferencesOfPointsOrNone) {
  CutMesh cut = random_cut(3);
  for (MeshPiece& piece : cut.pieces) std::ranges::fill(piece.mesh.point_refs, 0);
  for (const int of_points : {0, 1}) {
    cut.pieces[1].mesh.point_refs[0] = of_points;
    for (const int ranks : kRankCounts) {
      const TemporaryDirectory directory;
      write_on(ranks, cut.pieces, [&](Peers& peers, const auto& mine) {
        write_pieces_as_vtu(peers, mine, directory / "m.pvtu");
      });
      for (const auto& [name, bytes] : all_files(directory.path()))
        EXPECT_EQ(meshing::count(bytes, "type=\"Int32\" Name=\"ref\""), 1 + of_points) << name;
    }
  }
}

/// What follows a keyword of a text file, up to the next keyword.
std::vector<std::int64_t> numbers_after(const fs::path& path, const std::string& keyword) {
  std::ifstream text(path);
  std::string word;
  while (text >> word && word != keyword) {
  }
  std::vector<std::int64_t> numbers;
  for (std::int64_t number; text >> number;) numbers.push_back(number);
  return numbers;
}

/// Vertices that two pieces share as the files say: (this piece, other piece, number in the whole mesh,
/// place).
using Shared = std::tuple<std::int64_t, std::int64_t, std::int64_t, std::array<double, 3>>;

std::set<Shared> shared_in(const fs::path& path, std::int64_t piece) {
  const std::vector<std::int64_t> parts = numbers_after(path, "ParallelVertexCommunicators");
  const std::vector<std::int64_t> rows = numbers_after(path, "ParallelCommunicatorVertices");
  const MeshData mesh = meshing::read_gmf_mesh(path);
  EXPECT_EQ(parts.size(), 1 + 2 * static_cast<std::size_t>(parts.at(0)));
  std::vector<std::int64_t> counts(static_cast<std::size_t>(parts.at(0)));
  std::set<Shared> shared;
  for (std::size_t i = 0; i + 2 < rows.size(); i += 3) {
    const auto communicator = static_cast<std::size_t>(rows[i + 2]);
    ++counts.at(communicator);
    const meshing::Point& p = mesh.points.at(static_cast<std::size_t>(rows[i] - 1));
    shared.insert({piece, parts.at(1 + 2 * communicator), rows[i + 1], {p.x, p.y, p.z}});
  }
  for (std::size_t c = 0; c < counts.size(); ++c) EXPECT_EQ(counts[c], parts.at(2 + 2 * c));
  return shared;
}

TEST(PiecesForParmmg, ReadBackAreThePiecesAndNameEachOther) {
  for (unsigned seed = 0; seed < 7; ++seed) {
    SCOPED_TRACE(seed);
    const CutMesh cut = random_cut(seed);
    const MergedMesh merged = merge_pieces(cut.pieces);
    for (const int ranks : {1, 3}) {
      const TemporaryDirectory directory;
      write_on(ranks, cut.pieces, [&](Peers& peers, const auto& mine) {
        write_pieces_for_parmmg(peers, mine, directory / "m.mesh");
      });
      EXPECT_EQ(directory.num_entries(), 2 * cut.pieces.size());
      std::set<Shared> all, mirrored;
      std::size_t expected = 0;
      for (const MeshPiece& piece : cut.pieces) {
        const std::string name = "m." + std::to_string(piece.subdomain.value);
        meshing::expect_equal(meshing::read_gmf_mesh(directory / (name + ".mesh")), piece.mesh);
        meshing::expect_equal(meshing::read_gmf_solution(directory / (name + ".sol")),
                              meshing::solution_from_metric(piece.log_metrics));
        all.merge(shared_in(directory / (name + ".mesh"), piece.subdomain.value));
        expected += piece.shared.size();
      }
      for (const auto& [piece, other, number, place] : all) {
        mirrored.insert({other, piece, number, place});
        const meshing::Point& p = merged.mesh.points.at(static_cast<std::size_t>(number - 1));
        EXPECT_EQ((std::array<double, 3>{p.x, p.y, p.z}), place);
      }
      EXPECT_EQ(all.size(), expected);
      EXPECT_EQ(all, mirrored);
    }
  }
}

TEST(PiecesForParmmg, BinaryFilesHoldTheSame) {
  const CutMesh cut = random_cut(4);
  const TemporaryDirectory directory;
  SelfPeers alone;
  write_pieces_for_parmmg(alone, cut.pieces, directory / "m.meshb");
  const MeshPiece& piece = cut.pieces[1];
  meshing::expect_equal(meshing::read_gmf_mesh(directory / "m.1.meshb"), piece.mesh);
  ASSERT_FALSE(piece.shared.empty());
  // Behind the mesh: keyword 71 with its count and pairs, keyword 73 with triples, End; words of 4 bytes.
  std::set<SubdomainId> others;
  for (const auto& shared : piece.shared) others.insert(shared.other);
  const std::string bytes = bytes_of(directory / "m.1.meshb");
  std::vector<std::int32_t> words(5 + 2 * others.size() + 3 * piece.shared.size() + 2);
  std::memcpy(words.data(), bytes.data() + bytes.size() - 4 * words.size(), 4 * words.size());
  EXPECT_EQ(words[0], 71);
  EXPECT_EQ(words[2], static_cast<std::int32_t>(others.size()));
  EXPECT_EQ(words[3], static_cast<std::int32_t>(others.begin()->value));
  const std::size_t second = 3 + 2 * others.size();
  EXPECT_EQ(words[second], 73);
  EXPECT_EQ(static_cast<std::size_t>(words[1]), bytes.size() - 4 * (words.size() - second));
  EXPECT_EQ(words[words.size() - 2], 54);
}

/// The message with which every rank fails; there must be one, and only one.
template <class Write>
std::string common_issue(int ranks, const std::vector<MeshPiece>& pieces, const Write& write) {
  std::mutex mutex;
  std::set<std::string> issues;
  write_on(ranks, pieces, [&](Peers& peers, const auto& mine) {
    std::string issue = "none";
    try {
      write(peers, mine);
    } catch (const meshing::InputError& error) {
      issue = error.what();
    }
    const std::lock_guard lock(mutex);
    issues.insert(issue);
  });
  EXPECT_EQ(issues.size(), 1u);
  return *issues.begin();
}

TEST(PieceFiles, AFailureRemovesWhatOthersHaveWritten) {
  const CutMesh cut = random_cut(5);
  for (const int ranks : kRankCounts) {
    const TemporaryDirectory directory;
    for (const std::string name : {"m_2.vtu", "m.2.solb", "n.pvtu"}) fs::create_directory(directory / name);
    expect_contains(common_issue(ranks, cut.pieces,
                                 [&](Peers& peers, const auto& mine) {
                                   write_pieces_as_vtu(peers, mine, directory / "m.pvtu");
                                 }),
                    "m_2.vtu: cannot write: Is a directory");
    expect_contains(common_issue(ranks, cut.pieces,
                                 [&](Peers& peers, const auto& mine) {
                                   write_pieces_as_vtu(peers, mine, directory / "n.pvtu");
                                 }),
                    "n.pvtu: cannot write: Is a directory");
    expect_contains(common_issue(ranks, cut.pieces,
                                 [&](Peers& peers, const auto& mine) {
                                   write_pieces_for_parmmg(peers, mine, directory / "m.meshb");
                                 }),
                    "m.2.solb: cannot write: Is a directory");
    EXPECT_EQ(directory.num_entries(), 3u);
  }
}

}  // namespace
}  // namespace weft::partition::piece_files_test
