// Checkpoints on disk: what is whole, what is kept, what is damaged; numbers in few bytes.
#include "graph/adaptation/checkpoint_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <set>

#include "graph/adaptation/word_packing.h"
#include "meshing/base/error.h"

namespace weft::graph::adaptation::checkpoint_files_test {
namespace {

namespace fs = std::filesystem;

class CheckpointFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("weft-checkpoint-" + std::to_string(getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  static engine::Payload payload(std::size_t size) {
    engine::Payload p;
    p.bytes.resize(17, std::byte{3});
    p.segments.push_back(engine::Blob::adopt(std::vector<std::uint32_t>(size, 7)));
    return p;
  }

  void write(std::uint64_t number, bool complete) const {
    const fs::path at = checkpoint_folder(folder, number);
    fs::create_directories(at);
    CheckpointFile file(at / rank_file(0));
    for (std::uint32_t i = 1; i < 4; ++i)
      file.add(CheckpointRecord::Kind::object, {engine::Rank(0), i}, CheckpointFile::pack(payload(i * 5000)));
    file.commit();
    CheckpointManifest manifest{11, 3, 2, 0, {fs::file_size(at / rank_file(0))}};
    if (complete) std::ofstream(at / kManifestName) << manifest.text();
  }

  fs::path folder;
};

TEST_F(CheckpointFiles, RecordsComeBackAsTheyWere) {
  write(1, true);
  const CheckpointReader reader(folder / "1" / rank_file(0));
  ASSERT_EQ(reader.index().size(), 3u);
  for (std::uint32_t i = 1; i < 4; ++i) {
    const engine::Payload read = reader.read(reader.index()[i - 1]), was = payload(i * 5000);
    EXPECT_EQ(reader.index()[i - 1].object.number, i);
    EXPECT_EQ(read.bytes, was.bytes);
    ASSERT_EQ(read.segments.size(), 1u);
    EXPECT_TRUE(std::ranges::equal(read.segments[0].bytes(), was.segments[0].bytes()));
  }
}

TEST_F(CheckpointFiles, OneWithoutItsManifestOrWithAShortFileDoesNotExist) {
  write(1, true);
  write(2, true);
  write(3, false);
  ASSERT_EQ(find_checkpoints(folder).size(), 2u);
  EXPECT_EQ(find_checkpoints(folder)[0].number, 2u);
  EXPECT_EQ(find_checkpoints(folder)[0].manifest.home_ranks, 2);
  EXPECT_EQ(last_number(folder), 3u) << "a new one must not mix with it";
  fs::resize_file(folder / "2" / rank_file(0), 100);
  ASSERT_EQ(find_checkpoints(folder).size(), 1u);
  EXPECT_EQ(find_checkpoints(folder)[0].number, 1u);
}

TEST_F(CheckpointFiles, TwoAreKeptAndOneOnItsWay) {
  for (const std::uint64_t number : {1, 2, 4, 5}) write(number, true);
  write(3, false);
  write(6, false);
  remove_old_checkpoints(folder, 2);
  std::set<std::string> left;
  for (const auto& entry : fs::directory_iterator(folder)) left.insert(entry.path().filename());
  EXPECT_EQ(left, (std::set<std::string>{"4", "5", "6"}));
}

TEST_F(CheckpointFiles, AnyChangedByteIsFound) {
  write(1, true);
  const fs::path path = folder / "1" / rank_file(0);
  const std::uintmax_t size = fs::file_size(path);
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const auto at = static_cast<std::streamoff>(random() % size);
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(at);
    const char was = static_cast<char>(file.get());
    file.seekp(at);
    file.put(static_cast<char>(was ^ static_cast<char>(1 + random() % 255)));
    file.close();
    EXPECT_THROW(
        {
          const CheckpointReader reader(path);
          for (const CheckpointRecord& record : reader.index()) reader.read(record);
        },
        meshing::InputError)
        << "byte " << at;
    std::fstream back(path, std::ios::in | std::ios::out | std::ios::binary);
    back.seekp(at);
    back.put(was);
  }
}

TEST_F(CheckpointFiles, RecordsThatAreNoneAreRefusedThoughTheirHashesFit) {
  const std::vector<std::byte> good = CheckpointFile::pack(payload(500));
  const fs::path path = folder / rank_file(0);
  std::mt19937 random(6);
  for (std::size_t i = 0; i < 200; ++i) {
    std::vector<std::byte> bad = good;
    if (i % 2 == 0) bad.resize(random() % good.size());
    if (i % 2 == 1) bad[random() % 24] = static_cast<std::byte>(8 + random() % 248);  // the sizes
    CheckpointFile file(path);
    file.add(CheckpointRecord::Kind::object, {engine::Rank(0), 1}, bad);
    file.commit();
    const CheckpointReader reader(path);
    EXPECT_THROW(reader.read(reader.index()[0]), meshing::InputError);
  }
}

TEST_F(CheckpointFiles, WhatARunHasLeftUnfinishedGoesAndNothingElse) {
  write(1, false);
  write(2, true);
  write(3, true);
  write(4, false);
  remove_incomplete(folder, 1);
  EXPECT_TRUE(fs::exists(checkpoint_folder(folder, 1))) << "another run may be writing it";
  EXPECT_EQ(find_checkpoints(folder).size(), 2u);
  EXPECT_FALSE(fs::exists(checkpoint_folder(folder, 4)));
}

TEST_F(CheckpointFiles, ManifestsThatAreNoneAreRefused) {
  const std::string good = CheckpointManifest{5, 2, 1, 0, {10, 20}}.text();
  ASSERT_TRUE(CheckpointManifest::parse(good));
  EXPECT_EQ(CheckpointManifest::parse(good)->file_sizes, (std::vector<std::uint64_t>{10, 20}));
  for (std::size_t length = 0; length + 2 < good.size(); ++length)
    EXPECT_FALSE(CheckpointManifest::parse(good.substr(0, length))) << length;
}

TEST(WordPacking, ComesBackForAnyLengthAndContent) {
  std::mt19937 random(1);
  for (std::size_t size = 0; size < 300; ++size) {
    std::vector<std::byte> data(size), packed, back(size);
    for (std::byte& b : data) b = static_cast<std::byte>(size % 3 == 0 ? random() : size % 7);
    pack_words(data, packed);
    EXPECT_TRUE(unpack_words(packed, back).empty());
    EXPECT_EQ(back, data);
    const auto cut = std::span(packed).first(packed.size() - 1);  // the lag is always there
    EXPECT_THROW(unpack_words(cut, back), std::runtime_error);
  }
}

TEST(WordPacking, IndicesThatAreNearEachOtherTakeHalf) {
  std::vector<std::uint32_t> tets;
  std::mt19937 random(1);
  for (std::uint32_t i = 0; i < 40000; ++i) tets.push_back(i / 4 + random() % 1000);
  std::vector<std::byte> packed;
  pack_words(std::as_bytes(std::span(tets)), packed);
  EXPECT_LT(packed.size(), 0.6 * 4 * static_cast<double>(tets.size()));
}

}  // namespace
}  // namespace weft::graph::adaptation::checkpoint_files_test
