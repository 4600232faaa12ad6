// Files of meshes in slices have the bytes of those of the whole mesh.
#include "partition/fields/slice_files.h"

#include <gtest/gtest.h>

#include <map>

#include "meshing/io/mesh_file.h"
#include "meshing/io/vtk/pvtu.h"
#include "meshing/mesh/structured_box.h"
#include "partition/fields/slice_pieces.h"
#include "tests/meshing/io/format_support.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"

namespace weft::partition::slice_files_test {
namespace {

namespace fs = std::filesystem;
using meshing::bytes_of;
using meshing::Field;
using meshing::MeshContents;
using meshing::TemporaryDirectory;

/// A box of two regions and two markers with names, fields, and a point that no element uses.
MeshContents named_box(std::array<std::uint32_t, 3> cells = {4, 3, 2}) {
  MeshContents box;
  box.mesh = meshing::structured_box({cells, {0, 0, 0}, {4, 3, 2}});
  for (std::size_t t = 0; t < box.mesh.tet_refs.size(); t += 3) box.mesh.tet_refs[t] = 5;
  box.mesh.points.push_back({9, 8, 7});
  box.mesh.point_refs.push_back(-3);
  box.names.set(2, 1, "inflow");
  box.names.set(2, 4, "the wall");
  box.names.set(3, 5, "solid");
  box.complete();
  Field scalar{Field::Kind::scalar, {}, "mach"}, tensor{Field::Kind::tensor, {}, "metric"};
  for (std::size_t i = 0; i < box.mesh.points.size(); ++i) {
    scalar.values.push_back(1.0 / static_cast<double>(i + 1));
    for (int c = 0; c < 6; ++c) tensor.values.push_back(static_cast<double>(i) + c / 7.0);
  }
  box.fields = {box.mesh.points.size(), {scalar, tensor}};
  return box;
}

MeshContents empty_mesh() {
  MeshContents empty;
  empty.complete();
  return empty;
}

/// The values of a slice's points.
meshing::SolutionData values_of_slice(const meshing::SolutionData& all, const MeshSlice& slice) {
  meshing::SolutionData mine{slice.points.size(), {}};
  for (const Field& field : all.fields) {
    const auto n = static_cast<std::size_t>(components(field.kind));
    const auto first = field.values.begin() + static_cast<std::ptrdiff_t>(n * slice.first_point);
    mine.fields.push_back(
        {field.kind, {first, first + static_cast<std::ptrdiff_t>(n * slice.points.size())}, field.name});
  }
  return mine;
}

template <class Write>
std::vector<std::exception_ptr> write_on(int ranks, unsigned seed, const MeshContents& contents,
                                         const Write& write) {
  const support::MetricMesh whole{contents.mesh, {}};
  return support::run_ranks_caught(ranks, [&](Peers& peers) {
    const MeshSlice slice = support::slice_of(whole, peers.rank(), ranks, seed);
    write(peers, slice, values_of_slice(contents.fields, slice),
          peers.rank() == 0 ? contents.names : meshing::RefNames{});
  });
}

/// All files of a folder.
std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = entry.is_directory() ? "" : bytes_of(entry.path());
  return files;
}

template <class Action>
void for_ranks_and_shares(const Action& action) {
  for (const int ranks : {1, 2, 3, 4})
    for (const unsigned seed : {0u, 3u}) {  // of 3 some shares are empty
      SCOPED_TRACE(std::to_string(ranks) + " ranks, shares " + std::to_string(seed));
      action(ranks, seed);
    }
}

TEST(SliceFiles, HaveTheBytesOfTheWholeMesh) {
  constexpr auto kAscii = meshing::WriteOptions::Encoding::ascii;
  struct Case {
    const char* name;
    meshing::WriteOptions options = {};
  };
  for (const auto& [name, options] : {Case{"m.su2"},
                                      {"m.vtu"},
                                      {"m.vtu", {.encoding = kAscii}},
                                      {"m.vtu", {.compress = true}},
                                      {"m.msh"},
                                      {"m.msh", {.encoding = kAscii}},
                                      {"m.msh", {.gmsh_version = 2}},
                                      {"m.msh", {.encoding = kAscii, .gmsh_version = 2}},
                                      {"m.lb8.ugrid"},
                                      {"m.b4.ugrid"},
                                      {"m.ugrid"},
                                      {"m.meshb"},
                                      {"m.mesh"}})
    for (const MeshContents& contents : {named_box(), empty_mesh()}) {
      SCOPED_TRACE(name);
      const TemporaryDirectory expected;
      meshing::write_mesh_contents(expected / name, contents, options);
      for_ranks_and_shares([&](int ranks, unsigned seed) {
        const TemporaryDirectory directory;
        for (const auto& thrown :
             write_on(ranks, seed, contents, [&](auto&peers, auto&slice, auto&&fields, auto&&names) {
               peers.set_most_writers(1 + static_cast<int>(seed) % 3);
               write_mesh_of_slices(peers, slice, fields, names, directory / name, options);
             }))
          EXPECT_FALSE(thrown);
        EXPECT_TRUE(files_of(directory.path()) == files_of(expected.path()));
      });
    }
}

/// Blocks whose bytes are of several ranks, and ranks with several blocks of an array.
TEST(SliceFiles, OfManyCompressedBlocksHaveTheBytesOfTheWholeMesh) {
  const MeshContents box = named_box({16, 16, 16});
  const TemporaryDirectory expected;
  const meshing::WriteOptions options{.compress = true};
  meshing::write_mesh_contents(expected / "m.vtu", box, options);
  for_ranks_and_shares([&](int ranks, unsigned seed) {
    const TemporaryDirectory directory;
    for (const auto& thrown :
         write_on(ranks, seed, box, [&](auto&peers, auto&slice, auto&&fields, auto&&names) {
           write_mesh_of_slices(peers, slice, fields, names, directory / "m.vtu", options);
         }))
      EXPECT_FALSE(thrown);
    EXPECT_TRUE(files_of(directory.path()) == files_of(expected.path()));
  });
}

TEST(SliceFiles, AreRefusedWhereRoundingBreaksATet) {
  MeshContents box = named_box();
  const auto first = static_cast<std::uint32_t>(box.mesh.points.size());
  const double small = 1e-12;
  for (const meshing::Point& p :
       {meshing::Point{1, 1, 1}, {1 + small, 1, 1}, {1, 1 + small, 1}, {1, 1, 1 + small}})
    box.mesh.points.push_back(p);
  box.mesh.tets.push_back({first, first + 1, first + 2, first + 3});
  box.complete();
  box.mesh.point_refs.resize(box.mesh.points.size());
  box.mesh.tet_refs.resize(box.mesh.tets.size());
  box.fields = {box.mesh.points.size(), {}};
  const TemporaryDirectory directory;
  const std::string expected =
      meshing::message_of([&] { meshing::write_mesh_contents(directory / "m.b4.ugrid", box); });
  meshing::expect_contains(expected, "would lose its volume");
  for_ranks_and_shares([&](int ranks, unsigned seed) {
    for (const auto& thrown :
         write_on(ranks, seed, box, [&](auto&peers, auto&slice, auto&&fields, auto&&names) {
           write_mesh_of_slices(peers, slice, fields, names, directory / "m.b4.ugrid");
         }))
      EXPECT_EQ(meshing::message_of([&] {
                  if (thrown) std::rethrow_exception(thrown);
                }),
                expected);
    EXPECT_EQ(directory.num_entries(), 0u);
  });
}

TEST(SliceFiles, OfCgnsHoldTheWholeMesh) {
  const MeshContents box = named_box();
  const TemporaryDirectory directory;
  meshing::write_mesh_contents(directory / "whole.cgns", box);
  const MeshContents expected = meshing::read_mesh_contents(directory / "whole.cgns");
  for_ranks_and_shares([&](int ranks, unsigned seed) {
    for (const auto& thrown :
         write_on(ranks, seed, box, [&](auto&peers, auto&slice, auto&&fields, auto&&names) {
           peers.set_most_writers(1 + static_cast<int>(seed) % 3);
           write_mesh_of_slices(peers, slice, fields, names, directory / "m.cgns");
         }))
      EXPECT_FALSE(thrown);
    const MeshContents read = meshing::read_mesh_contents(directory / "m.cgns");
    meshing::expect_equal(read.mesh, expected.mesh);
    meshing::expect_equal(read.fields, expected.fields);
    EXPECT_EQ(read.names.all(), expected.names.all());
    EXPECT_EQ(fs::file_size(directory / "m.cgns"), fs::file_size(directory / "whole.cgns"));
  });
}

TEST(SliceFiles, OfPiecesHaveTheBytesOfTheWholeMesh) {
  for (const MeshContents& contents : {named_box(), empty_mesh()})
    for (const meshing::WriteOptions& options :
         {meshing::WriteOptions{.pieces = 1},
          {.compress = true, .pieces = 3},
          {.encoding = meshing::WriteOptions::Encoding::ascii, .pieces = 7}}) {
      SCOPED_TRACE(options.pieces);
      const TemporaryDirectory expected;
      meshing::write_pvtu(expected / "m.pvtu", contents, options);
      for_ranks_and_shares([&](int ranks, unsigned seed) {
        const TemporaryDirectory directory;
        for (const auto& thrown :
             write_on(ranks, seed, contents, [&](auto&peers, auto&slice, auto&&fields, auto&&) {
               write_slices_as_pvtu(peers, slice, fields, directory / "m.pvtu", options);
             }))
          EXPECT_FALSE(thrown);
        EXPECT_TRUE(files_of(directory.path()) == files_of(expected.path()));
      });
    }
}

TEST(SliceFiles, ThatFailOnOneRankFailOnAllAndLeaveNothing) {
  const MeshContents box = named_box();
  for (const int ranks : {1, 2, 4}) {
    const TemporaryDirectory directory;
    fs::create_directory(directory / "m_2.vtu");
    fs::create_directory(directory / "m_2.vtu/taken");
    const auto thrown = write_on(ranks, 0, box, [&](auto& peers, auto& slice, auto&& fields, auto&&) {
      write_slices_as_pvtu(peers, slice, fields, directory / "m.pvtu", {.pieces = 4});
    });
    for (const auto& exception : thrown)
      meshing::expect_contains(meshing::message_of([&] {
                                 if (exception) std::rethrow_exception(exception);
                               }),
                               "m_2.vtu: cannot write");
    EXPECT_EQ(directory.num_entries(), 1u);
  }
  for (const char* name : {"none/m.su2", "none/m.cgns"}) {
    const TemporaryDirectory directory;
    for (const auto& exception : write_on(3, 0, box, [&](auto&peers, auto&slice, auto&&fields, auto&&names) {
           write_mesh_of_slices(peers, slice, fields, names, directory / name);
         }))
      EXPECT_TRUE(exception) << name;
    EXPECT_EQ(directory.num_entries(), 0u);
  }
}

}  // namespace
}  // namespace weft::partition::slice_files_test
