// What a rank makes of the copies of a snapshot: a file, a checkpoint on rank 0, or nothing.
#include "graph/adaptation/checkpoint_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <thread>

#include "meshing/base/error.h"

namespace weft::graph::adaptation::checkpoint_writer_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

engine::Payload copy_of(std::uint32_t number) {
  const engine::ObjectId id{engine::Rank(0), number};
  engine::Payload copy;
  copy.bytes.resize(sizeof id);
  std::memcpy(copy.bytes.data(), &id, sizeof id);
  return copy;
}

class CheckpointWriting : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("weft-checkpoint-writing-" + std::to_string(getpid()));
    fs::create_directories(folder);
    writer.begin({11, 3, 1, 0, {}});
  }
  void TearDown() override {
    interrupt = false;
    writer.end();
    fs::remove_all(folder);
  }

  /// Whether it has been stored, once that is known.
  bool stored(std::uint64_t epoch) {
    while (!writer.stored(epoch)) std::this_thread::sleep_for(1ms);
    return *writer.stored(epoch);
  }
  /// The whole of one.
  void write(std::uint64_t epoch) {
    writer.object(epoch, copy_of(1));
    writer.close(epoch);
    writer.finish(epoch, stored(epoch));
  }
  std::vector<CheckpointRecord> records(std::uint64_t number) const {
    return CheckpointReader(checkpoint_folder(folder, number) / rank_file(0)).index();
  }

  fs::path folder;
  std::atomic<bool> asked = false, interrupt = false;
  CheckpointWriter writer{fs::temp_directory_path() / ("weft-checkpoint-writing-" + std::to_string(getpid())),
                          1e9,
                          &asked,
                          &interrupt,
                          0,
                          1};
};

TEST_F(CheckpointWriting, ObjectsAndMessagesOfAnEpochAreInItsFile) {
  writer.object(1, copy_of(1));
  writer.message(1, copy_of(2));
  writer.object(1, copy_of(3));
  writer.close(1);
  ASSERT_TRUE(stored(1));
  writer.finish(1, true);
  writer.end();
  EXPECT_EQ(find_checkpoints(folder).size(), 1u);
  EXPECT_EQ(writer.written().written, 1u);
  EXPECT_EQ(records(1).size(), 3u);
  EXPECT_EQ(std::ranges::count(records(1), CheckpointRecord::Kind::message, &CheckpointRecord::kind), 1);
}

TEST_F(CheckpointWriting, ARankThatHasNothingWritesAFileToo) {
  writer.close(1);
  EXPECT_TRUE(stored(1));
  EXPECT_TRUE(records(1).empty());
}

TEST_F(CheckpointWriting, WorkThatWasCutShortNeverBecomesACheckpoint) {
  writer.object(1, copy_of(1));
  interrupt = true;
  writer.close(1);
  std::this_thread::sleep_for(50ms);
  EXPECT_FALSE(writer.stored(1));
  asked = true;
  EXPECT_FALSE(writer.wanted());
  writer.end();
  EXPECT_TRUE(find_checkpoints(folder).empty());
}

TEST_F(CheckpointWriting, WhatComesLateForAnEpochBeforeIsNotOfTheNext) {
  writer.object(1, copy_of(1));
  writer.give_up();
  writer.object(2, copy_of(2));
  writer.object(1, copy_of(3));
  writer.message(1, copy_of(4));
  writer.object(2, copy_of(5));
  writer.close(2);
  ASSERT_TRUE(stored(2));
  EXPECT_FALSE(writer.stored(1));
  ASSERT_EQ(records(2).size(), 2u);
  EXPECT_EQ(records(2)[0].object.number, 2u);
  EXPECT_EQ(records(2)[1].object.number, 5u);
}

TEST_F(CheckpointWriting, WhoAskedForOneThatWasGivenUpStillWantsIt) {
  asked = true;
  EXPECT_TRUE(writer.wanted());
  EXPECT_FALSE(asked);
  writer.give_up();
  EXPECT_TRUE(writer.wanted());
  write(1);
  writer.give_up();
  EXPECT_FALSE(writer.wanted());
}

TEST_F(CheckpointWriting, OneThatFailedLeavesNothing) {
  writer.object(1, copy_of(1));
  writer.close(1);
  ASSERT_TRUE(stored(1));
  writer.finish(1, false);  // another rank's disk was full
  writer.end();
  EXPECT_TRUE(fs::is_empty(folder));
  EXPECT_NE(writer.written().failure, "");
  write(2);
  writer.end();
  EXPECT_EQ(writer.written().failure, "");
  EXPECT_EQ(find_checkpoints(folder).size(), 1u);
}

TEST_F(CheckpointWriting, WhatIsInTheWayOfAFolderCostsTheCheckpointAndStays) {
  std::ofstream(folder / "1") << "a file of somebody";
  write(1);
  writer.end();
  EXPECT_NE(writer.written().failure, "");
  EXPECT_TRUE(fs::is_regular_file(folder / "1"));
}

TEST_F(CheckpointWriting, FilesOfOthersInFoldersWithNumbersStay) {
  for (const char* name : {"100", "007", "3"}) fs::create_directories(folder / name);
  std::ofstream(folder / "100" / "U") << "velocities";
  std::ofstream(folder / "007" / "rank-0") << "not of a checkpoint's folder";
  std::ofstream(folder / "2026") << "notes";
  writer.begin({11, 3, 1, last_number(folder), {}});
  for (const std::uint64_t epoch : {1, 2, 3}) write(epoch);
  writer.end();
  writer.remove_unfinished();
  EXPECT_EQ(find_checkpoints(folder).size(), 2u) << "two are kept";
  for (const char* path : {"100/U", "007/rank-0", "2026", "3"})
    EXPECT_TRUE(fs::exists(folder / path)) << path;
}

TEST_F(CheckpointWriting, AFolderIsOneRunsOnly) {
  const fs::path own = folder / "locked";
  {
    const CheckpointLock lock(own, 0ms);
    EXPECT_THROW(CheckpointLock(own, 200ms), meshing::InputError);
  }
  EXPECT_NO_THROW(CheckpointLock(own, 0ms));
}

}  // namespace
}  // namespace weft::graph::adaptation::checkpoint_writer_test
