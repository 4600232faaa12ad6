// Records of vertices on a CAD model and the carried model in GMF files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/mesh/structured_box.h"

namespace weft::meshing::gmf_association_test {
namespace {

namespace fs = std::filesystem;

class GmfAssociation : public testing::Test {
 protected:
  GmfAssociation() {
    mesh_ = structured_box({{1, 1, 1}});
    mesh_.association.nodes = {{0, 1}, {7, 8}};
    mesh_.association.edges = {{0, 1, 0.25, 1}, {1, 1, -1.0 / 3, 1}};
    mesh_.association.faces = {{0, 2, 0.1, 0.7, 2}, {3, 2, 1e-300, -5, 2}};
  }
  ~GmfAssociation() override { fs::remove(path_); }

  fs::path at(const char* extension) {
    path_ = fs::temp_directory_path() / ("weft_association_" + std::to_string(getpid()) + extension);
    return path_;
  }
  void set_model(std::size_t bytes, bool in_words) {
    mesh_.association.model_in_words = in_words;
    for (std::size_t i = 0; i < bytes; ++i)
      mesh_.association.model.push_back(static_cast<std::uint8_t>(17 * i + 128));
  }

  MeshData mesh_;
  fs::path path_;
};

TEST_F(GmfAssociation, IsReadBackToTheLastBitFromBinaryFilesOfEveryVersion) {
  for (const int version : {2, 3, 4}) {
    write_gmf_mesh(at(".meshb"), mesh_, version);
    EXPECT_EQ(read_gmf_mesh(path_).association, mesh_.association) << "version " << version;
  }
}

TEST_F(GmfAssociation, IsReadBackToTheLastBitFromText) {
  write_gmf_mesh(at(".mesh"), mesh_);
  EXPECT_EQ(read_gmf_mesh(path_).association, mesh_.association);
}

TEST_F(GmfAssociation, KeepsAModelInBothLayouts) {
  for (const bool in_words : {false, true})
    for (const std::size_t bytes : {1u, 4u, 7u, 1001u}) {
      mesh_.association.model.clear();
      set_model(bytes, in_words);
      for (const int version : {2, 4}) {
        write_gmf_mesh(at(".meshb"), mesh_, version);
        EXPECT_EQ(read_gmf_mesh(path_).association, mesh_.association) << bytes << in_words << version;
      }
    }
}

TEST_F(GmfAssociation, OfRefinesLayoutCountsBytes) {
  set_model(5, false);
  write_gmf_mesh(at(".meshb"), mesh_, 2);
  std::ifstream file(path_, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  const auto word = [&](std::size_t from) {
    std::int32_t value;
    std::memcpy(&value, bytes.data() + from, 4);
    return value;
  };
  // ... keyword, next position, count, five bytes, then End and its position.
  const std::size_t begin = bytes.size() - 8 - 5 - 12;
  EXPECT_EQ(word(begin), 126);
  EXPECT_EQ(word(begin + 8), 5);
  EXPECT_EQ(static_cast<std::uint8_t>(bytes[begin + 12]), 128);
}

TEST_F(GmfAssociation, TextHoldsAModelInWords) {
  set_model(9, false);
  write_gmf_mesh(at(".mesh"), mesh_);
  EXPECT_EQ(read_gmf_mesh(path_).association.model, mesh_.association.model);
}

TEST_F(GmfAssociation, OfAVertexThatIsNotThereIsRefused) {
  mesh_.association.faces[1].vertex = 100;
  write_gmf_mesh(at(".meshb"), mesh_);
  try {
    read_gmf_mesh(path_);
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("VerticesOnGeometricTriangles 2"));
    EXPECT_THAT(error.what(), testing::HasSubstr("101"));
  }
}

TEST_F(GmfAssociation, WithALengthThatDoesNotFitItsWordsIsRefused) {
  set_model(9, true);
  write_gmf_mesh(at(".mesh"), mesh_);
  std::ifstream in(path_);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::size_t count = text.find("ByteFlow\n4\n9\n");
  ASSERT_NE(count, std::string::npos);
  text.replace(count, 13, "ByteFlow\n4\n13\n");
  std::ofstream(path_) << text;
  EXPECT_THROW(read_gmf_mesh(path_), InputError);
}

}  // namespace
}  // namespace weft::meshing::gmf_association_test
