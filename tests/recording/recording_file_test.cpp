// The names of a recording's file: partial while it is written, then its own, the one before kept.

#include "prehend/recording/recording_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/recording/split_writer.h"
#include "tests/recording/recording_test_files.h"

namespace prehend::recording {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

void record_nothing(const std::string& path) { SplitWriter(path, {}, {}).close(); }

std::string error_of(const std::string& path) {
  try {
    record_nothing(path);
    return "";
  } catch (const McapError& error) {
    return error.what();
  }
}

TEST(RecordingFile, GetsItsNameWhenItIsWholeAndTheOneBeforeIsKept) {
  TemporaryFolder folder;
  const std::string path = folder.file("a.mcap");
  write_file(path, "one");
  {
    SplitWriter writer(path, {}, {});
    EXPECT_EQ(read_file(path), "one");
    EXPECT_THAT(writer.files(), ElementsAre(path + ".partial"));
    writer.close();
    EXPECT_THAT(writer.files(), ElementsAre(path));
  }
  EXPECT_EQ(read_file(path + ".1"), "one");
  EXPECT_TRUE(McapReader(path).complete());
  EXPECT_FALSE(fs::exists(path + ".partial"));
  const std::string two = read_file(path);
  record_nothing(path);
  EXPECT_EQ(read_file(path + ".1"), two);
}

TEST(RecordingFile, WhatAKilledRecorderLeftIsNeverOverwritten) {
  TemporaryFolder folder;
  const std::string path = folder.file("a.mcap");
  for (int i = 1; i <= 3; ++i) {
    write_file(path + ".partial", "rest " + std::to_string(i));
    SplitWriter writer(path, {}, {});
    EXPECT_THAT(writer.left_over(), ElementsAre(path + ".partial." + std::to_string(i)));
    writer.close();
  }
  for (int i = 1; i <= 3; ++i) {
    EXPECT_EQ(read_file(path + ".partial." + std::to_string(i)), "rest " + std::to_string(i));
  }
}

TEST(RecordingFile, PartsHaveTheSameLife) {
  TemporaryFolder folder;
  write_file(folder.file("a_0000.mcap"), "old");
  SplitWriter writer(folder.file("a.mcap"), {}, {0, 1'000});
  const auto channel = writer.add_channel("/raw", "t.P", example_schema(), {});
  writer.write(channel, "node", 1, 10, 10, "");
  writer.write(channel, "node", 2, 2'000, 2'000, "");
  EXPECT_THAT(writer.files(),
              ElementsAre(folder.file("a_0000.mcap"), folder.file("a_0001.mcap.partial")));
  EXPECT_EQ(read_file(folder.file("a_0000.mcap.1")), "old");
  writer.close();
  EXPECT_TRUE(McapReader(folder.file("a_0001.mcap")).complete());
}

TEST(RecordingFile, TwoRecordersOfOneFileAreRefused) {
  TemporaryFolder folder;
  const std::string path = folder.file("a.mcap");
  SplitWriter first(path, {}, {});
  EXPECT_THAT(error_of(path), HasSubstr("another recorder is writing it"));
  EXPECT_THROW(McapWriter(path + ".partial"), McapError) << "before it empties the file";
  first.close();
  EXPECT_TRUE(McapReader(path).complete());
}

TEST(RecordingFile, AMissingOneIsSaidWithWhatItsRecorderLeft) {
  TemporaryFolder folder;
  write_file(folder.file("a.mcap.partial"), "rest");
  try {
    McapReader reader(folder.file("a.mcap"));
    ADD_FAILURE() << "it is not there";
  } catch (const McapError& error) {
    EXPECT_THAT(error.what(), HasSubstr("prehend bag recover mends it"));
  }
}

TEST(RecordingFile, OtherThingsOfThatNameAreRefused) {
  TemporaryFolder folder;
  fs::create_directory(folder.file("a.mcap"));
  EXPECT_THAT(error_of(folder.file("a.mcap")), HasSubstr("something that is no file"));
  fs::create_directory(folder.file("b.mcap.partial"));
  EXPECT_THAT(error_of(folder.file("b.mcap")), HasSubstr("something that is no file"));
  EXPECT_THAT(error_of("/dev/null"), HasSubstr("something that is no file"));
}

TEST(RecordingFile, ALinkMeansWhatItPointsTo) {
  TemporaryFolder folder;
  fs::create_directory(folder.file("disk"));
  write_file(folder.file("disk/a.mcap"), "one");
  fs::create_symlink(folder.file("disk/a.mcap"), folder.file("link.mcap"));
  record_nothing(folder.file("link.mcap"));
  EXPECT_TRUE(fs::is_symlink(folder.file("link.mcap")));
  EXPECT_TRUE(McapReader(folder.file("link.mcap")).complete());
  EXPECT_EQ(read_file(folder.file("disk/a.mcap.1")), "one");
}

}  // namespace
}  // namespace prehend::recording
