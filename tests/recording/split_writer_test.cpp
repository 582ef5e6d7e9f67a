#include "prehend/recording/split_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "prehend/recording/recording_check.h"
#include "tests/recording/recording_test_files.h"

namespace prehend::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

McapWriterOptions uncompressed() {
  McapWriterOptions options;
  options.compression = Compression::kNone;
  return options;
}

std::string message_of(int value) {  // of t.P, x = value
  const double x = value;
  std::string data = "\x09";
  data.append(reinterpret_cast<const char*>(&x), sizeof x);
  return data;
}

// What was written, and how often it was found in the parts apart from repeated messages.
struct Part {
  std::vector<std::string> own;       // topic:sequence
  std::vector<std::string> repeated;  // topic:sequence
};

Part contents_of(const std::string& path) {
  EXPECT_THAT(check_recording(path).problems, IsEmpty()) << path;
  McapReader reader(path);
  EXPECT_TRUE(reader.complete());
  std::uint64_t repeated = 0;
  for (const McapMetadata& item : reader.metadata()) {
    if (item.name == kPartMetadata) repeated = std::stoull(item.entries.at("repeated_messages"));
  }
  Part part;
  for (const McapMessage& message : all_messages(reader)) {
    auto& list = repeated > 0 ? part.repeated : part.own;
    if (repeated > 0) --repeated;
    list.push_back(reader.channels().at(message.channel_id).topic + ":" +
                   std::to_string(message.sequence));
  }
  return part;
}

TEST(SplitWriter, WritesOneFileUnlessToldToSplit) {
  TemporaryFolder folder;
  SplitWriter writer(folder.file("a.mcap"), {}, {});
  const auto channel = writer.add_channel("/p", "t.P", example_schema(), {});
  for (int i = 1; i <= 100; ++i) {
    writer.write(channel, "node", static_cast<std::uint32_t>(i), 10, 10, message_of(i));
  }
  writer.close();
  EXPECT_THAT(writer.files(), ElementsAre(folder.file("a.mcap")));
  EXPECT_EQ(contents_of(folder.file("a.mcap")).own.size(), 100u);
}

TEST(SplitWriter, EveryMessageIsInExactlyOnePartAndEveryPartIsWhole) {
  TemporaryFolder folder;
  SplitWriter writer(folder.file("a.mcap"), uncompressed(), {100'000, 0}, [] {
    return std::vector<McapMetadata>{{"end", {{"key", "value"}}}};
  });
  writer.add_attachment({1, 1, "launch.yaml", "text/yaml", "nodes: []\n"});
  writer.add_metadata({"run", {{"seed", "7"}}});
  const auto a = writer.add_channel("/a", "t.P", example_schema(), {});
  const auto b = writer.add_channel("/b", "t.P", example_schema(), {});
  std::mt19937 random(3);
  std::multiset<std::string> expected;
  for (std::uint32_t i = 1; i <= 5'000; ++i) {
    const bool first = random() % 2 == 0;
    std::string data;  // encodings one after another are one, too
    for (std::size_t n = random() % 30 + 1; n > 0; --n) data += message_of(static_cast<int>(i));
    writer.write(first ? a : b, "node", i, i, i, data);
    expected.insert((first ? "/a:" : "/b:") + std::to_string(i));
  }
  writer.close();
  ASSERT_GT(writer.files().size(), 4u);
  EXPECT_EQ(writer.files()[3], folder.file("a_0003.mcap"));
  std::multiset<std::string> found;
  std::uint64_t bytes = 0;
  for (const std::string& file : writer.files()) {
    const Part part = contents_of(file);
    found.insert(part.own.begin(), part.own.end());
    EXPECT_THAT(part.repeated, IsEmpty()) << "nothing was latched";
    McapReader reader(file);
    EXPECT_EQ(reader.attachments().size(), 1u);
    EXPECT_EQ(reader.channels().size(), 2u);
    EXPECT_EQ(reader.metadata().size(), 3u) << "run, part, end";
    EXPECT_LT(reader.file_size(), 120'000u);
    bytes += reader.file_size();
  }
  EXPECT_EQ(found, expected);
  EXPECT_EQ(writer.message_count(), 5'000u);
  EXPECT_EQ(writer.bytes_written(), bytes);
}

TEST(SplitWriter, APartBeginsWithTheLatchedMessagesThatHoldThen) {
  TemporaryFolder folder;
  SplitWriter writer(folder.file("run.v1.mcap"), {}, {0, 1'000});
  const auto camera = writer.add_channel("/camera", "t.P", example_schema(), {{"latched", "1"}});
  const auto health = writer.add_channel("/health", "t.P", example_schema(), {{"latched", "2"}});
  const auto touch = writer.add_channel("/touch", "t.P", example_schema(), {});
  writer.write(camera, "camera", 1, 10, 9, message_of(1));
  writer.write(health, "arm", 1, 20, 19, message_of(1));
  writer.write(health, "arm", 2, 30, 29, message_of(2));
  writer.write(health, "arm", 3, 40, 39, message_of(3));
  writer.write(health, "hand", 1, 50, 49, message_of(4));
  writer.write(touch, "hand", 1, 60, 59, message_of(5));
  writer.write(camera, "camera", 2, 1'100, 1'090, message_of(6));  // 1000 ns are over
  writer.write(touch, "hand", 2, 2'100, 2'090, message_of(7));     // and again
  writer.close();
  ASSERT_THAT(writer.files(),
              ElementsAre(folder.file("run.v1_0000.mcap"), folder.file("run.v1_0001.mcap"),
                          folder.file("run.v1_0002.mcap")));
  EXPECT_THAT(contents_of(writer.files()[0]).own.size(), 6u);
  const Part second = contents_of(writer.files()[1]);
  EXPECT_THAT(second.repeated, ElementsAre("/camera:1", "/health:2", "/health:3", "/health:1"));
  EXPECT_THAT(second.own, ElementsAre("/camera:2"));
  const Part third = contents_of(writer.files()[2]);
  EXPECT_THAT(third.repeated, ElementsAre("/camera:2", "/health:2", "/health:3", "/health:1"));
  EXPECT_THAT(third.own, ElementsAre("/touch:2"));

  McapReader reader(writer.files()[1]);
  const auto first = all_messages(reader).front();
  EXPECT_EQ(first.log_time, 1'100u) << "repeated at the time of the split";
  EXPECT_EQ(first.publish_time, 9u) << "its own";
}

// A shorter recording left the last parts of the one before, which seemed to be its own.
TEST(SplitWriter, PartsOfTheRecordingBeforeAreSetAside) {
  TemporaryFolder folder;
  const auto record = [&](int parts) {
    SplitWriter writer(folder.file("a.mcap"), {}, {0, 1'000});
    const auto touch = writer.add_channel("/touch", "t.P", example_schema(), {});
    for (int i = 0; i < parts; ++i) {
      writer.write(touch, "hand", 1, 10 + 1'000 * static_cast<std::uint64_t>(i), 9, message_of(i));
    }
    writer.close();
    EXPECT_EQ(writer.files().size(), static_cast<std::size_t>(parts));
  };
  record(4);
  record(2);
  EXPECT_TRUE(std::filesystem::exists(folder.file("a_0001.mcap")));
  for (const char* name : {"a_0002.mcap", "a_0003.mcap"}) {
    EXPECT_FALSE(std::filesystem::exists(folder.file(name))) << name;
    EXPECT_TRUE(std::filesystem::exists(folder.file(name + std::string(".1")))) << name;
  }
}

TEST(SplitWriter, SaysWhatItRefuses) {
  TemporaryFolder folder;
  EXPECT_THROW(SplitWriter(folder.file("a.mcap"), {}, {10, 0}), std::invalid_argument);
  EXPECT_THROW(SplitWriter(folder.file("no/a.mcap"), {}, {0, 5}), McapError);
  SplitWriter writer(folder.file("b.mcap"), {}, {});
  EXPECT_THROW(writer.write(0, "node", 1, 1, 1, "x"), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::recording
