// Checking recordings, and choosing from them: topic patterns, latched messages, word lists.

#include "prehend/recording/recording_check.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>

#include "prehend/recording/latched_messages.h"
#include "prehend/recording/topic_filter.h"
#include "prehend/recording/word_list.h"
#include "tests/recording/recording_test_files.h"

namespace prehend::recording {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string checked_message_of(double x) {
  std::string data = "\x09";
  data.append(reinterpret_cast<const char*>(&x), sizeof x);
  return data;
}

McapWriterOptions all_checksums(Compression compression) {
  McapWriterOptions options;
  options.compression = compression;
  options.data_section_crc = true;
  options.chunk_size = 500;
  return options;
}

// About 2 kB with every kind of record.
void write_checked_recording(const std::string& path,
                             Compression compression = Compression::kNone) {
  McapWriter writer(path, all_checksums(compression));
  const auto schema = writer.add_schema("t.P", "protobuf", example_schema());
  const auto p = writer.add_channel("/p", "protobuf", schema);
  const auto raw = writer.add_channel("/raw", "raw", 0);
  writer.add_attachment({3, 2, "launch.yaml", "text/yaml", "nodes: []\n"});
  writer.add_metadata({"run", {{"seed", "7"}}});
  for (std::uint32_t i = 1; i <= 10; ++i) {
    writer.write(p, i, 10 * i, 10 * i, checked_message_of(i));
    writer.write(raw, i, 10 * i + 1, 10 * i, "anything");
  }
  writer.close();
}

class CheckRecording : public testing::TestWithParam<Compression> {};
INSTANTIATE_TEST_SUITE_P(Compressions, CheckRecording,
                         testing::Values(Compression::kNone, Compression::kLz4,
                                         Compression::kZstd));

TEST_P(CheckRecording, FindsNothingInASoundFile) {
  TemporaryFolder folder;
  write_checked_recording(folder.file("a.mcap"), GetParam());
  const RecordingCheck check = check_recording(folder.file("a.mcap"));
  EXPECT_THAT(check.problems, IsEmpty());
  EXPECT_EQ(check.messages, 20u);
  EXPECT_GT(check.chunks, 1u);
  EXPECT_EQ(check.attachments, 1u);
}

// The checksum of the data section covers all before it, that of the summary all after.
TEST_P(CheckRecording, FindsAnyFlippedBit) {
  TemporaryFolder folder;
  write_checked_recording(folder.file("a.mcap"), GetParam());
  const std::string bytes = read_file(folder.file("a.mcap"));
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] ^= static_cast<char>(1 << i % 8);
    write_file(folder.file("b.mcap"), damaged);
    EXPECT_FALSE(check_recording(folder.file("b.mcap")).problems.empty()) << "byte " << i;
  }
}

// With what a recorder writes: 15 of 739 changes were not seen, in the metadata and at the ends of
// the file. Bytes under a checksum of 32 bits cannot change alone, whatever their new value; where
// there is none (the magics, DataEnd, the checksums themselves), every value is tried.
TEST(CheckRecordings, FindsAnyChangeOfASingleByte) {
  TemporaryFolder folder;
  const std::string path = folder.file("a.mcap");
  {
    McapWriterOptions options;
    options.chunk_size = 200;
    McapWriter writer(path, options);
    const auto p = writer.add_channel("/p", "protobuf",
                                      writer.add_schema("t.P", "protobuf", example_schema()));
    writer.add_attachment({3, 2, "a.yaml", "text/yaml", "nodes: []\n"});
    writer.add_metadata({"prehend.run", {{"host", "h"}}});
    for (std::uint32_t i = 1; i <= 3; ++i) writer.write(p, i, i, i, checked_message_of(i));
    writer.close();
  }
  ASSERT_THAT(check_recording(path).problems, IsEmpty());
  ASSERT_THAT(check_recording(path).notes, IsEmpty());
  const std::string bytes = read_file(path);
  std::uint64_t summary = 0;  // where it begins, as the footer says
  std::memcpy(&summary, bytes.data() + bytes.size() - 28, sizeof summary);
  const std::size_t data_end = summary - 13;
  ASSERT_EQ(bytes[data_end], '\x0f');
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_GE(file, 0);
  std::size_t unseen = 0, tried = 0;
  const auto try_value = [&](std::size_t at, char value) {
    if (value == bytes[at]) return;
    ASSERT_EQ(::pwrite(file, &value, 1, static_cast<off_t>(at)), 1);
    ++tried;
    bool is_seen = true;
    try {
      is_seen = !check_recording(path).problems.empty();
    } catch (const McapError&) {  // it is no recording any more
    }
    if (!is_seen) ++unseen;
    EXPECT_TRUE(is_seen) << "byte " << at << " of " << bytes.size() << " as "
                         << int{static_cast<unsigned char>(value)};
  };
  for (std::size_t at = 0; at < bytes.size() && unseen < 20; ++at) {
    const bool is_covered =
        at >= 8 && (at < data_end || (at >= data_end + 13 && at < bytes.size() - 12));
    for (int value = 0; value < 256; ++value) {
      const int flipped = value ^ static_cast<unsigned char>(bytes[at]);
      const bool is_one_bit = (flipped & (flipped - 1)) == 0;
      const bool is_end = value == 0 || value == 255;
      if (!is_covered || is_one_bit || is_end) try_value(at, static_cast<char>(value));
    }
    ASSERT_EQ(::pwrite(file, &bytes[at], 1, static_cast<off_t>(at)), 1);
  }
  ::close(file);
  EXPECT_GT(tried, 10 * bytes.size());
  EXPECT_THAT(check_recording(path).problems, IsEmpty()) << "as it was";
}

TEST(CheckRecordings, SaysWhereThereIsNoChecksum) {
  TemporaryFolder folder;
  McapWriterOptions options;
  options.data_section_crc = false;
  McapWriter writer(folder.file("a.mcap"), options);
  writer.add_metadata({"run", {{"seed", "7"}}});
  writer.add_channel("/raw", "raw", 0);
  writer.close();
  EXPECT_THAT(check_recording(folder.file("a.mcap")).problems, IsEmpty());
  EXPECT_THAT(check_recording(folder.file("a.mcap")).notes,
              ElementsAre(HasSubstr("the data section has no checksum")));
}

TEST_P(CheckRecording, FindsAnyCut) {
  TemporaryFolder folder;
  write_checked_recording(folder.file("a.mcap"), GetParam());
  const std::string bytes = read_file(folder.file("a.mcap"));
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    write_file(folder.file("b.mcap"), bytes.substr(0, cut));
    if (cut < 8) {
      EXPECT_THROW(check_recording(folder.file("b.mcap")), McapError) << cut;
    } else {
      EXPECT_FALSE(check_recording(folder.file("b.mcap")).problems.empty()) << cut;
    }
  }
}

// The reader itself: every cut and every flipped bit of a small file, without a crash, and never a
// message that was not written.
TEST_P(CheckRecording, ReaderSurvivesEveryCutAndFlippedBit) {
  TemporaryFolder folder;
  write_checked_recording(folder.file("a.mcap"), GetParam());
  const std::string bytes = read_file(folder.file("a.mcap"));
  const auto read = [&](const std::string& content) {
    write_file(folder.file("b.mcap"), content);
    McapReader reader(folder.file("b.mcap"));
    for (const auto& index : reader.attachments()) {
      try {
        reader.read_attachment(index);
      } catch (const McapError&) {
      }
    }
    latched_before(reader, {}, 55);
    return all_messages(reader).size();
  };
  for (std::size_t cut = 8; cut < bytes.size(); ++cut) {
    EXPECT_LE(read(bytes.substr(0, cut)), 20u) << cut;
  }
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] ^= static_cast<char>(1 << (i * 5) % 8);
    EXPECT_LE(read(damaged), 20u) << i;
  }
}

TEST(CheckRecordings, NamesWhatIsWrong) {
  TemporaryFolder folder;
  const auto problems_of = [&](auto&& write) {
    {
      McapWriter writer(folder.file("a.mcap"));
      write(writer);
      writer.close();
    }
    return check_recording(folder.file("a.mcap")).problems;
  };
  EXPECT_THAT(problems_of([](McapWriter& writer) {
                const auto schema = writer.add_schema("t.P", "protobuf", example_schema());
                const auto p = writer.add_channel("/p", "protobuf", schema);
                writer.write(p, 1, 10, 10, checked_message_of(1));
                writer.write(p, 2, 9, 9, checked_message_of(2));
                writer.write(p, 3, 20, 20, "\x09?");
              }),
              ElementsAre(HasSubstr("/p: message 2 at byte 32 is earlier than the one before"),
                          HasSubstr("/p: message 3 at byte 32 cannot be decoded")));
  EXPECT_THAT(problems_of([](McapWriter& writer) {
                writer.add_channel("/p", "protobuf",
                                   writer.add_schema("t.Q", "protobuf", example_schema()));
              }),
              Contains(HasSubstr("the schema of t.Q does not define it")));
  write_file(folder.file("text"), "ply\nformat ascii 1.0\n");
  EXPECT_THROW(check_recording(folder.file("text")), McapError);
  EXPECT_THROW(check_recording(folder.file("none")), McapError);
}

TEST(TopicFilter, TakesNamesAndPatterns) {
  const TopicFilter filter{{"/camera/*", "/touch"}, {"*/raw"}};
  EXPECT_TRUE(filter.wants("/camera/left/image"));
  EXPECT_TRUE(filter.wants("/touch"));
  EXPECT_FALSE(filter.wants("/touch2"));
  EXPECT_FALSE(filter.wants("/camera/raw"));
  EXPECT_TRUE(TopicFilter().wants("/any"));
  EXPECT_EQ(filter.unmatched({"/camera/raw", "/touch"}), std::nullopt);
  EXPECT_EQ(filter.unmatched({"/camera/raw", "/tuoch"}), "/touch");
}

TEST(LatchedMessages, AreTheLastBeforeATimeAsManyAsWereLatched) {
  TemporaryFolder folder;
  {
    McapWriterOptions options;
    options.chunk_size = 200;
    McapWriter writer(folder.file("a.mcap"), options);
    const auto one = writer.add_channel("/one", "raw", 0, {{"latched", "1"}});
    const auto two = writer.add_channel("/two", "raw", 0, {{"latched", "2"}});
    const auto odd = writer.add_channel("/odd", "raw", 0, {{"latched", "what"}});
    const auto plain = writer.add_channel("/plain", "raw", 0);
    for (std::uint32_t i = 1; i <= 20; ++i) {
      writer.write(plain, i, 10 * i, i, "p");
      if (i <= 5) writer.write(two, i, 10 * i + 1, i, "2");
      if (i % 4 == 0) writer.write(one, i, 10 * i + 2, i, "1");
      if (i == 3) writer.write(odd, i, 10 * i + 3, i, "o");
    }
    writer.close();
  }
  McapReader reader(folder.file("a.mcap"));
  const auto found = [&](const TopicFilter& filter, std::uint64_t time) {
    std::vector<std::string> names;
    for (const auto& message : latched_before(reader, filter, time)) {
      names.push_back(reader.channels().at(message.channel_id).topic + ":" +
                      std::to_string(message.sequence));
    }
    return names;
  };
  EXPECT_THAT(found({}, 125), ElementsAre("/odd:3", "/two:4", "/two:5", "/one:12"));
  EXPECT_THAT(found({}, 122), ElementsAre("/odd:3", "/two:4", "/two:5", "/one:8"))
      << "not what comes at the time itself";
  EXPECT_THAT(found({{"/one"}, {}}, 1000), ElementsAre("/one:20"));
  EXPECT_THAT(found({}, 0), IsEmpty());
}

TEST(WordList, ComesBackAsItWas) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{}, {"/a", "/b/*"}, {"a file", "quo\"te", "back\\slash", ""}}) {
    EXPECT_EQ(split_words(joined_words(words)), words);
  }
  EXPECT_THAT(split_words("  /a   /b "), ElementsAre("/a", "/b"));
}

}  // namespace
}  // namespace prehend::recording
