#include "prehend/recording/mcap_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <signal.h>
#include <sys/resource.h>

#include <array>
#include <chrono>
#include <random>
#include <thread>

#include "tests/recording/recording_test_files.h"

namespace prehend::recording {
namespace {

using testing::HasSubstr;

// The 671 bytes of a recording worked out by hand from the public MCAP specification and read by
// the npm package @mcap/core: one message t.P{x: 1.5} on /p.
constexpr char kWorkedExample[] =
    "894d434150300d0a010c00000000000000000000000400000064656d6f06be0000000000000000ca9a3b00000000"
    "00ca9a3b00000000960000000000000068d4081c0000000096000000000000000342000000000000000100030000"
    "00742e500800000070726f746f627566290000000a270a07742e70726f746f12017422110a0150120c0a01781801"
    "20012801520178620670726f746f33041a0000000000000001000100020000002f700800000070726f746f627566"
    "00000000051f0000000000000001000700000000ca9a3b0000000000ca9a3b0000000009000000000000f83f0716"
    "0000000000000001001000000000ca9a3b000000006e000000000000000f04000000000000005a0dbf3203420000"
    "0000000000010003000000742e500800000070726f746f627566290000000a270a07742e70726f746f1201742211"
    "0a0150120c0a0178180120012801520178620670726f746f33041a0000000000000001000100020000002f700800"
    "000070726f746f627566000000000b38000000000000000100000000000000010001000000000000000000000001"
    "00000000ca9a3b0000000000ca9a3b000000000a00000001000100000000000000084a0000000000000000ca9a3b"
    "0000000000ca9a3b000000001d00000000000000c7000000000000000a0000000100e4000000000000001f000000"
    "0000000000000000960000000000000096000000000000000e11000000000000000310010000000000004b000000"
    "000000000e1100000000000000045b0100000000000023000000000000000e11000000000000000b7e0100000000"
    "000041000000000000000e110000000000000008bf01000000000000530000000000000002140000000000000010"
    "01000000000000120200000000000058cdb069894d434150300d0a";

std::string from_hex(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

McapWriterOptions example_options() {
  McapWriterOptions options;
  options.compression = Compression::kNone;
  options.data_section_crc = true;
  options.library = "demo";
  return options;
}

void write_example(const std::string& path, const McapWriterOptions& options) {
  McapWriter writer(path, options);
  const auto schema = writer.add_schema("t.P", "protobuf", example_schema());
  const auto channel = writer.add_channel("/p", "protobuf", schema);
  const double x = 1.5;
  std::string data = "\x09";
  data.append(reinterpret_cast<const char*>(&x), sizeof x);
  writer.write(channel, 7, 1000000000, 1000000000, data);
  writer.close();
}

TEST(McapWriter, WritesTheWorkedExampleByteForByte) {
  TemporaryFolder folder;
  write_example(folder.file("a.mcap"), example_options());
  EXPECT_EQ(read_file(folder.file("a.mcap")), from_hex(kWorkedExample));
}

TEST(McapWriter, TheWorkedExampleCutAtAnyByteGivesItsMessageOnceThatIsWhole) {
  TemporaryFolder folder;
  const std::string bytes = from_hex(kWorkedExample);
  constexpr std::size_t kMessageEnd = 228;
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    write_file(folder.file("a.mcap"), bytes.substr(0, cut));
    if (cut < 8) {
      EXPECT_THROW(McapReader(folder.file("a.mcap")), McapError) << cut;
      continue;
    }
    McapReader reader(folder.file("a.mcap"));
    EXPECT_FALSE(reader.complete()) << cut;
    EXPECT_FALSE(reader.problems().empty()) << cut;
    const auto messages = all_messages(reader);
    ASSERT_EQ(messages.size(), cut >= kMessageEnd ? 1u : 0u) << cut;
    for (const McapMessage& message : messages) EXPECT_EQ(message.sequence, 7u);
  }
}

TEST(McapWriter, AnyFlippedBitOfTheWorkedExamplesChunkIsReported) {
  TemporaryFolder folder;
  const std::string bytes = from_hex(kWorkedExample);
  for (std::size_t bit = 78 * 8; bit < 228 * 8; bit += 5) {
    std::string damaged = bytes;
    damaged[bit / 8] ^= static_cast<char>(1 << bit % 8);
    write_file(folder.file("a.mcap"), damaged);
    McapReader reader(folder.file("a.mcap"));
    EXPECT_TRUE(all_messages(reader).empty()) << bit;
    EXPECT_THAT(reader.problems(), testing::ElementsAre(HasSubstr("checksum is wrong"))) << bit;
  }
}

TEST(McapWriter, PartsOfAMessageAreJoined) {
  TemporaryFolder folder;
  McapWriter writer(folder.file("a.mcap"));
  const auto channel = writer.add_channel("/p", "raw", 0);
  const std::array<std::string_view, 4> parts{"ab", "", "c", "def"};
  writer.write(channel, 1, 5, 4, parts);
  writer.close();
  McapReader reader(folder.file("a.mcap"));
  const auto messages = all_messages(reader);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].data, "abcdef");
  EXPECT_EQ(messages[0].publish_time, 4u);
}

TEST(McapWriter, ClosesAChunkAtItsSizeAndGivesALargeMessageItsOwn) {
  TemporaryFolder folder;
  McapWriterOptions options;
  options.chunk_size = 10000;
  McapWriter writer(folder.file("a.mcap"), options);
  const auto channel = writer.add_channel("/p", "raw", 0);
  const std::string small(100, 'a'), large(50000, 'b');
  for (std::uint64_t i = 0; i < 30; ++i) writer.write(channel, 0, i, i, small);
  writer.write(channel, 0, 30, 30, large);
  EXPECT_EQ(writer.statistics().chunk_count, 2u) << "the small ones, then the large one alone";
  writer.write(channel, 0, 31, 31, small);
  writer.close();
  McapReader reader(folder.file("a.mcap"));
  ASSERT_EQ(reader.chunks().size(), 3u);
  EXPECT_LE(reader.chunks()[0].uncompressed_size, 10000u);
  EXPECT_EQ(reader.chunks()[1].message_start_time, 30u);
  EXPECT_EQ(reader.chunks()[1].message_end_time, 30u);
  EXPECT_EQ(all_messages(reader).size(), 32u);
}

TEST(McapWriter, ClosesAnOldChunkSoThatACrashCostsAtMostItsAge) {
  TemporaryFolder folder;
  McapWriterOptions options;
  options.chunk_age = std::chrono::milliseconds(20);
  McapWriter writer(folder.file("a.mcap"), options);
  const auto channel = writer.add_channel("/p", "raw", 0);
  writer.write(channel, 0, 1, 1, "x");
  writer.close_chunk_if_old();
  EXPECT_EQ(writer.statistics().chunk_count, 0u);
  std::this_thread::sleep_for(std::chrono::milliseconds(25));
  writer.close_chunk_if_old();
  EXPECT_EQ(writer.statistics().chunk_count, 1u);
  McapReader reader(folder.file("a.mcap"));  // the writer is still open
  EXPECT_FALSE(reader.complete());
  EXPECT_EQ(all_messages(reader).size(), 1u);
}

TEST(McapWriter, StoresAChunkThatDoesNotShrinkUncompressed) {
  TemporaryFolder folder;
  for (const auto compression : {Compression::kLz4, Compression::kZstd}) {
    McapWriterOptions options;
    options.compression = compression;
    McapWriter writer(folder.file("a.mcap"), options);
    const auto channel = writer.add_channel("/p", "raw", 0);
    std::mt19937 random(1);
    std::string noise(5000, ' ');
    for (char& byte : noise) byte = static_cast<char>(random());
    writer.write(channel, 0, 1, 1, noise);
    writer.close();
    McapReader reader(folder.file("a.mcap"));
    ASSERT_EQ(reader.chunks().size(), 1u);
    EXPECT_EQ(reader.chunks()[0].compression, "");
  }
}

TEST(McapWriter, SameInputGivesTheSameBytes) {
  TemporaryFolder folder;
  write_example(folder.file("a.mcap"), {});
  write_example(folder.file("b.mcap"), {});
  EXPECT_EQ(read_file(folder.file("a.mcap")), read_file(folder.file("b.mcap")));
}

TEST(McapWriter, AFullDiskIsReportedAndStaysReported) {
  if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "there is no /dev/full";
  try {
    McapWriter writer("/dev/full");
    FAIL() << "writing to a full disk succeeded";
  } catch (const McapError& error) {
    EXPECT_THAT(error.what(), HasSubstr("No space left on device"));
    EXPECT_THAT(error.what(), HasSubstr("/dev/full"));
  }
}

// Writes until the process' file size limit, a stand-in for a disk that fills up; ends the process.
[[noreturn]] void write_beyond_the_limit(const std::string& path) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{100000, 100000};
  ::setrlimit(RLIMIT_FSIZE, &limit);
  McapWriterOptions options;
  options.compression = Compression::kNone;
  options.chunk_size = 10000;
  McapWriter writer(path, options);
  const auto channel = writer.add_channel("/p", "raw", 0);
  try {
    for (std::uint64_t i = 0; i < 1000; ++i) writer.write(channel, 0, i, i, std::string(1000, 'x'));
  } catch (const McapError& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  try {
    writer.close();
  } catch (const McapError&) {
    ::_exit(0);
  }
  ::_exit(1);
}

TEST(McapWriter, AFileThatCannotGrowStaysReadableUpToItsLastWholeChunk) {
  TemporaryFolder folder;
  const std::string path = folder.file("a.mcap");
  EXPECT_EXIT(write_beyond_the_limit(path), testing::ExitedWithCode(0),
              "File too large; the recording ends there");
  McapReader reader(path);
  const std::size_t count = all_messages(reader).size();
  EXPECT_GT(count, 70u);
  EXPECT_LT(count, 100u);
  EXPECT_THAT(reader.problems(), testing::ElementsAre(HasSubstr(" 0 bytes at its end")));
}

TEST(McapWriter, RefusesWhatMakesNoSense) {
  TemporaryFolder folder;
  const std::string path = folder.file("a.mcap");
  McapWriterOptions options;
  options.chunk_size = 0;
  EXPECT_THROW(McapWriter(path, options), std::invalid_argument);
  options = {};
  options.zstd_level = 40;
  EXPECT_THROW(McapWriter(path, options), std::invalid_argument);
  EXPECT_THROW(McapWriter(folder.file("missing/a.mcap")), McapError);
  EXPECT_THROW(compression_named("gzip"), std::invalid_argument);

  McapWriter writer(path);
  EXPECT_THROW(writer.add_channel("/p", "protobuf", 3), std::invalid_argument);
  EXPECT_THROW(writer.write(1, 0, 0, 0, "x"), std::invalid_argument);
  writer.close();
  writer.close();
  EXPECT_THROW(writer.add_metadata({"late", {}}), McapError);
}

}  // namespace
}  // namespace prehend::recording
