// Result files: complete or absent.
#include "tools/library/jobs/outputs.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/mesh/structured_box.h"
#include "tools/common/inputs.h"

namespace weft::tools::outputs_test {
namespace {

namespace fs = std::filesystem;
using meshing::InputError;

class Outputs : public testing::Test {
 protected:
  Outputs() { fs::create_directories(folder_); }
  ~Outputs() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  const meshing::MeshData mesh_ = meshing::structured_box({{1, 1, 1}, {0, 0, 0}, {1, 1, 1}});
  const meshing::SolutionData solution_ = {8,
                                           {{meshing::Field::Kind::scalar, std::vector<double>(8, 1.0), ""}}};
  fs::path folder_ = fs::temp_directory_path() / ("weft-outputs-test-" + std::to_string(getpid()));
};

TEST_F(Outputs, TheSolutionLiesBesideTheMesh) {
  EXPECT_EQ(output_paths("a/b.meshb").solution, "a/b.solb");
  EXPECT_EQ(output_paths("b.mesh").solution, "b.sol");
  EXPECT_EQ(output_paths("b.vtu").solution, "b.solb");
  EXPECT_EQ(output_paths("b.pvtu").solution, "b.pvtu");
}

TEST_F(Outputs, ThePairIsWritten) {
  write_mesh_with_solution(output_paths(path("a.meshb")), mesh_, solution_);
  EXPECT_TRUE(fs::exists(path("a.meshb")));
  EXPECT_TRUE(fs::exists(path("a.solb")));
  EXPECT_EQ(files(), 2u);
}

TEST_F(Outputs, ThePiecesOfAPvtuHoldEverything) {
  write_mesh_with_solution(output_paths(path("a.pvtu")), mesh_, solution_, solution_);
  EXPECT_TRUE(fs::exists(path("a_0.vtu")));
  EXPECT_FALSE(fs::exists(path("a.solb")));
  EXPECT_FALSE(fs::exists(path("a-fields.solb")));
  EXPECT_EQ(meshing::read_solution(path("a.pvtu")).fields.size(), 2u);
}

TEST_F(Outputs, NothingIsLeftWhenOneOfThePairFails) {
  const OutputPaths paths{path("a.meshb"), path("missing/a.solb")};
  EXPECT_THROW(write_mesh_with_solution(paths, mesh_, solution_), InputError);
  EXPECT_EQ(files(), 0u);
}

TEST_F(Outputs, ErrorsNameTheFileThatTheUserKnows) {
  try {
    write_mesh_with_solution({path("missing/a.meshb"), path("a.solb")}, mesh_, solution_);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind(path("missing/a.meshb") + ": ", 0), 0u) << error.what();
  }
}

TEST_F(Outputs, TwoThatAreOneFileAreRefused) {
  const std::string again = (folder_ / "." / "a.json").string();
  try {
    keep_apart({{"--trace", path("a.json")}, {"--graph", path("b.json")}, {"--account", again}});
    FAIL();
  } catch (const OptionError& error) {
    EXPECT_EQ(error.option(), "--account");
    EXPECT_EQ(error.reason(), again + " would be written by --trace, too");
  }
  EXPECT_NO_THROW(
      keep_apart({{"--trace", path("a.json")}, {"--graph", path("b.json")}, {"-o", ""}, {"-p", ""}}));
  std::ofstream(path("a.json")) << "{}";
  std::filesystem::create_symlink("a.json", path("link.json"));
  EXPECT_THROW(keep_apart({{"--trace", path("a.json")}, {"--graph", path("link.json")}}), OptionError);
}

TEST_F(Outputs, AMissingFolderIsNotWritable) {
  EXPECT_THROW(check_writable(path("missing/a.meshb")), InputError);
  EXPECT_THROW(check_writable(folder_.string()), InputError);
  EXPECT_NO_THROW(check_writable(path("a.meshb")));
  EXPECT_EQ(files(), 0u);
}

TEST_F(Outputs, TextReplacesTheOldTextWhole) {
  write_text(path("a.json"), "old and longer");
  write_text(path("a.json"), "new");
  std::ostringstream text;
  text << std::ifstream(path("a.json")).rdbuf();
  EXPECT_EQ(text.str(), "new");
  EXPECT_EQ(files(), 1u);
}

TEST_F(Outputs, AFolderIsNotMadeOverAFile) {
  write_text(path("file"), "");
  EXPECT_THROW(make_folder(path("file/report")), InputError);
  EXPECT_NO_THROW(make_folder(path("a/b")));
}

}  // namespace
}  // namespace weft::tools::outputs_test
