#include "prehend/recording/mcap_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "tests/recording/recording_test_files.h"

namespace prehend::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Expected {
  std::string topic;
  std::uint32_t sequence;
  std::uint64_t log_time;
  std::string data;
  bool operator==(const Expected&) const = default;
};

// 300 messages on two topics with log times that overlap between chunks, and one empty topic.
std::vector<Expected> write_recording(const std::string& path, Compression compression) {
  McapWriterOptions options;
  options.compression = compression;
  options.chunk_size = 2000;
  McapWriter writer(path, options);
  const auto schema = writer.add_schema("t.P", "protobuf", example_schema());
  const auto a = writer.add_channel("/a", "protobuf", schema, {{"key", "value"}});
  const auto b = writer.add_channel("/b", "protobuf", schema);
  writer.add_channel("/never", "raw", 0);
  writer.add_attachment({3, 2, "launch.yaml", "text/yaml", "nodes: []\n"});
  std::mt19937 random(7);
  std::vector<Expected> expected;
  for (std::uint32_t i = 1; i <= 300; ++i) {
    const bool first = random() % 3 != 0;
    const std::uint64_t log_time = 1000 + 10 * i + random() % 400;
    const std::string data(random() % 90, static_cast<char>('a' + i % 26));
    writer.write(first ? a : b, i, log_time, log_time - 1, data);
    expected.push_back({first ? "/a" : "/b", i, log_time, data});
  }
  writer.add_metadata({"run", {{"seed", "7"}}});
  writer.close();
  std::stable_sort(expected.begin(), expected.end(),
                   [](const auto& x, const auto& y) { return x.log_time < y.log_time; });
  return expected;
}

std::vector<Expected> as_expected(McapReader& reader, const McapMessageFilter& filter = {}) {
  std::vector<Expected> found;
  for (const McapMessage& message : all_messages(reader, filter)) {
    found.push_back({reader.channels().at(message.channel_id).topic, message.sequence,
                     message.log_time, std::string(message.data)});
  }
  return found;
}

class RoundTrip : public testing::TestWithParam<Compression> {};
INSTANTIATE_TEST_SUITE_P(Compressions, RoundTrip,
                         testing::Values(Compression::kNone, Compression::kLz4,
                                         Compression::kZstd));

TEST_P(RoundTrip, EverythingComesBackInOrderOfTime) {
  TemporaryFolder folder;
  const auto expected = write_recording(folder.file("a.mcap"), GetParam());
  McapReader reader(folder.file("a.mcap"));
  EXPECT_TRUE(reader.complete());
  EXPECT_EQ(reader.library(), "prehend");
  EXPECT_EQ(as_expected(reader), expected);
  EXPECT_THAT(reader.problems(), IsEmpty());

  const McapStatistics& statistics = reader.statistics();
  EXPECT_EQ(statistics.message_count, 300u);
  EXPECT_EQ(statistics.channel_count, 3u);
  EXPECT_GT(statistics.chunk_count, 5u);
  EXPECT_EQ(statistics.message_start_time, expected.front().log_time);
  EXPECT_EQ(statistics.message_end_time, expected.back().log_time);
  EXPECT_EQ(reader.channels().at(1).metadata.at("key"), "value");
  EXPECT_EQ(reader.schema_of(reader.channels().at(1))->data, example_schema());
  EXPECT_EQ(reader.schema_of(reader.channels().at(3)), nullptr);
  ASSERT_EQ(reader.attachments().size(), 1u);
  const McapAttachment attachment = reader.read_attachment(reader.attachments()[0]);
  EXPECT_EQ(attachment.data, "nodes: []\n");
  EXPECT_EQ(attachment.media_type, "text/yaml");
  EXPECT_EQ(attachment.create_time, 2u);
  ASSERT_EQ(reader.metadata().size(), 1u);
  EXPECT_EQ(reader.metadata()[0].entries.at("seed"), "7");
}

TEST_P(RoundTrip, TopicsAndTimesAreFiltered) {
  TemporaryFolder folder;
  auto expected = write_recording(folder.file("a.mcap"), GetParam());
  std::erase_if(expected, [](const Expected& message) {
    return message.topic != "/b" || message.log_time < 2000 || message.log_time > 3000;
  });
  ASSERT_GT(expected.size(), 10u);
  McapReader reader(folder.file("a.mcap"));
  EXPECT_EQ(as_expected(reader, {{"/b"}, 2000, 3000}), expected);
}

// What a killed recorder leaves: no DataEnd, no summary, no footer.
TEST_P(RoundTrip, AFileWithoutItsEndGivesTheSameMessages) {
  TemporaryFolder folder;
  const auto expected = write_recording(folder.file("a.mcap"), GetParam());
  McapReader whole(folder.file("a.mcap"));
  const McapChunkIndex& last = whole.chunks().back();
  const std::string bytes = read_file(folder.file("a.mcap"));
  write_file(folder.file("b.mcap"), bytes.substr(0, last.chunk_start_offset + last.chunk_length));
  McapReader reader(folder.file("b.mcap"));
  EXPECT_FALSE(reader.complete());
  EXPECT_EQ(as_expected(reader), expected);
  EXPECT_EQ(reader.statistics().message_count, 300u);
  EXPECT_EQ(reader.attachments().size(), 1u);
  EXPECT_THAT(reader.problems(), ElementsAre(HasSubstr("ends without a footer")));
}

// A prefix of the file: no crash, and every message of each chunk that is whole comes out.
TEST_P(RoundTrip, ACutLosesOnlyTheTornChunk) {
  TemporaryFolder folder;
  write_recording(folder.file("a.mcap"), GetParam());
  McapReader whole(folder.file("a.mcap"));
  const std::string bytes = read_file(folder.file("a.mcap"));
  const auto messages_before = [&](std::uint64_t end) {
    write_file(folder.file("c.mcap"), bytes.substr(0, end));
    McapReader reader(folder.file("c.mcap"));
    return all_messages(reader).size();
  };
  std::map<std::uint64_t, std::size_t> messages_by_chunk_end;
  for (const McapChunkIndex& chunk : whole.chunks()) {
    const std::uint64_t end = chunk.chunk_start_offset + chunk.chunk_length;
    messages_by_chunk_end[end] = messages_before(end);
  }
  EXPECT_EQ(messages_by_chunk_end.rbegin()->second, 300u);

  std::size_t last_count = 0;
  for (std::size_t cut = 8; cut < bytes.size(); cut += 41) {
    write_file(folder.file("b.mcap"), bytes.substr(0, cut));
    const auto first_torn = messages_by_chunk_end.upper_bound(cut);
    const std::size_t in_whole_chunks =
        first_torn == messages_by_chunk_end.begin() ? 0 : std::prev(first_torn)->second;
    McapReader reader(folder.file("b.mcap"));
    EXPECT_FALSE(reader.complete()) << cut;
    EXPECT_FALSE(reader.problems().empty()) << cut;
    const std::size_t count = all_messages(reader).size();
    EXPECT_EQ(count, reader.statistics().message_count);
    EXPECT_GE(count, in_whole_chunks) << cut;
    EXPECT_GE(count, last_count) << cut;
    last_count = count;
  }
  EXPECT_EQ(last_count, 300u);
}

TEST_P(RoundTrip, AFlippedBitInAChunkSkipsThatChunkAndIsReported) {
  TemporaryFolder folder;
  write_recording(folder.file("a.mcap"), GetParam());
  McapReader whole(folder.file("a.mcap"));
  const auto all = all_messages(whole).size();
  std::string bytes = read_file(folder.file("a.mcap"));
  const McapChunkIndex& chunk = whole.chunks().at(2);
  bytes[chunk.chunk_start_offset + chunk.chunk_length / 2] ^= 4;
  write_file(folder.file("b.mcap"), bytes);
  McapReader reader(folder.file("b.mcap"));
  const auto left = all_messages(reader).size();
  EXPECT_LT(left, all);
  EXPECT_GT(left, all * 3 / 4);
  EXPECT_THAT(reader.problems(), ElementsAre(HasSubstr("skipped the chunk at byte " +
                                                       std::to_string(chunk.chunk_start_offset))));
}

// Any one flipped bit may cost messages, never invent one, never crash; and it is noticed unless it
// hits what no checksum covers.
TEST_P(RoundTrip, AnyFlippedBitNeitherCrashesNorInventsMessages) {
  TemporaryFolder folder;
  const auto expected = write_recording(folder.file("a.mcap"), GetParam());
  const std::string bytes = read_file(folder.file("a.mcap"));
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    std::string damaged = bytes;
    damaged[8 + random() % (bytes.size() - 8)] ^= static_cast<char>(1 << random() % 8);
    write_file(folder.file("b.mcap"), damaged);
    McapReader reader(folder.file("b.mcap"));
    for (const Expected& message : as_expected(reader)) {
      EXPECT_NE(std::find(expected.begin(), expected.end(), message), expected.end());
    }
  }
}

std::string record_with(std::uint8_t opcode, std::uint64_t length, const std::string& content) {
  std::string out(1, static_cast<char>(opcode));
  for (int i = 0; i < 8; ++i) out.push_back(static_cast<char>(length >> (8 * i)));
  return out + content;
}

std::string little_endian(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out.push_back(i < 8 ? static_cast<char>(value >> (8 * i)) : '\0');
  return out;
}

const std::string kMagicBytes("\x89MCAP0\r\n", 8);

TEST(McapReader, HostileLengthsAllocateNothing) {
  TemporaryFolder folder;
  const std::string header = record_with(1, 8, std::string(8, '\0'));
  const std::uint64_t huge = std::uint64_t{1} << 62;
  const std::string chunk_fields = little_endian(0, 16) + little_endian(huge, 8) +
                                   little_endian(0, 4) + little_endian(3, 4) + "lz4";
  for (const std::string& tail :
       {record_with(6, huge, ""), record_with(6, ~std::uint64_t{0}, "abc"),
        record_with(3, 10, little_endian(1, 2) + little_endian(0xFFFFFFFF, 4) + "abcd"),
        record_with(4, 12, little_endian(0, 4) + little_endian(0xFFFFFFF0, 4) + "abcd"),
        record_with(6, chunk_fields.size() + 8 + 4, chunk_fields + little_endian(huge, 8) + "abcd"),
        record_with(6, chunk_fields.size() + 8 + 4, chunk_fields + little_endian(4, 8) + "abcd"),
        record_with(9, 8, little_endian(huge, 8)), record_with(0x0C, 4, "\xff\xff\xff\xff"),
        record_with(0, 5, "abcde"), record_with(0x77, huge, "")}) {
    write_file(folder.file("a.mcap"), kMagicBytes + header + tail);
    McapReader reader(folder.file("a.mcap"));
    EXPECT_THAT(all_messages(reader), IsEmpty());
    EXPECT_FALSE(reader.problems().empty());
  }
}

TEST(McapReader, ASummaryThatPointsOutsideIsNotBelieved) {
  TemporaryFolder folder;
  const std::string footer =
      record_with(2, 20, little_endian(~std::uint64_t{0} - 3, 8) + little_endian(0, 12));
  write_file(folder.file("a.mcap"), kMagicBytes + record_with(1, 8, std::string(8, '\0')) +
                                        record_with(0x0F, 4, std::string(4, '\0')) + footer +
                                        kMagicBytes);
  McapReader reader(folder.file("a.mcap"));
  EXPECT_TRUE(reader.complete());
  EXPECT_THAT(reader.problems(), ElementsAre(HasSubstr("points outside")));
}

TEST(McapReader, MessagesOutsideOfChunksAndUnknownRecordsAreRead) {
  TemporaryFolder folder;
  const std::string channel = little_endian(0, 4) + little_endian(2, 4) + "/x" +
                              little_endian(3, 4) + "raw" + little_endian(0, 4);
  const auto message = [](std::uint64_t time) {
    return record_with(5, 24,
                       little_endian(0, 2) + little_endian(1, 4) + little_endian(time, 8) +
                           little_endian(time, 8) + "hi");
  };
  write_file(folder.file("a.mcap"), kMagicBytes + record_with(1, 8, std::string(8, '\0')) +
                                        record_with(4, channel.size(), channel) + message(20) +
                                        record_with(0x90, 3, "abc") + message(10));
  McapReader reader(folder.file("a.mcap"));
  const auto found = as_expected(reader);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].log_time, 10u);
  EXPECT_EQ(found[1].data, "hi");
}

TEST(McapReader, SaysWhatIsWrongWithFilesThatAreNoRecordings) {
  TemporaryFolder folder;
  const auto error_of = [&](const std::string& path) {
    try {
      McapReader reader(path);
    } catch (const McapError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error_of(folder.file("none.mcap")), HasSubstr("No such file"));
  EXPECT_THAT(error_of(folder.file("")), HasSubstr("is not a file"));
  write_file(folder.file("empty"), "");
  EXPECT_THAT(error_of(folder.file("empty")), HasSubstr("is empty"));
  write_file(folder.file("text"), "ply\nformat ascii 1.0\n");
  EXPECT_THAT(error_of(folder.file("text")), HasSubstr("not an MCAP recording"));
  write_file(folder.file("next"), "\x89MCAP1\r\n");
  EXPECT_THAT(error_of(folder.file("next")), HasSubstr("version '1'"));
}

TEST(McapReader, ADamagedAttachmentIsNotHandedOut) {
  TemporaryFolder folder;
  write_recording(folder.file("a.mcap"), Compression::kNone);
  std::string bytes = read_file(folder.file("a.mcap"));
  bytes[bytes.find("nodes: []")] = 'N';
  write_file(folder.file("a.mcap"), bytes);
  McapReader reader(folder.file("a.mcap"));
  ASSERT_EQ(reader.attachments().size(), 1u);
  EXPECT_THROW(reader.read_attachment(reader.attachments()[0]), McapError);
}

}  // namespace
}  // namespace prehend::recording
