// Recordings against the public reader and writer of the format, the npm package @mcap/core.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cstdio>
#include <filesystem>

#include "msgs/sensors.pb.h"
#include "prehend/recording/protobuf_schema.h"
#include "tests/recording/recording_test_files.h"

namespace prehend::recording {
namespace {

const std::string kFolder = "tests/recording/npm";

struct CommandResult {
  int exit_code;
  std::string output;
};

CommandResult run(const std::string& command) {
  FILE* pipe = ::popen(command.c_str(), "r");
  std::string output;
  std::array<char, 4096> buffer;
  while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    output.append(buffer.data(), got);
  }
  const int status = ::pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, output};
}

class NpmReader : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (run("node --version 2>/dev/null").exit_code != 0) {
      missing_ = "node is not installed";
      return;
    }
    const auto installed = [] {
      return std::filesystem::exists(kFolder + "/node_modules/@mcap/core") &&
             std::filesystem::exists(kFolder + "/node_modules/@mcap/support") &&
             std::filesystem::exists(kFolder + "/node_modules/protobufjs");
    };
    if (installed()) return;
    run("cd " + kFolder + " && timeout 60 npm ci --no-audit --no-fund 2>&1");
    if (!installed()) missing_ = "the npm packages are missing: run npm ci in " + kFolder;
  }
  void SetUp() override {
    if (!missing_.empty()) GTEST_SKIP() << missing_;
  }

  CommandResult check(const std::string& action, const std::string& file) {
    return run("timeout 30 node " + kFolder + "/check.cjs " + action + " " + folder_.file(file) +
               " 2>&1");
  }

  // 400 tactile frames and 5 clouds of 100 kB.
  void write_recording(const std::string& file, Compression compression) {
    McapWriterOptions options;
    options.compression = compression;
    options.data_section_crc = true;
    options.chunk_size = 50000;
    McapWriter writer(folder_.file(file), options);
    const auto add = [&](const std::string& topic, const google::protobuf::Descriptor& type) {
      return writer.add_channel(
          topic, "protobuf",
          writer.add_schema(type.full_name(), "protobuf", file_descriptor_set(type)));
    };
    const auto touch = add("/touch", *msgs::TactileFrame::descriptor());
    const auto cloud = add("/cloud", *msgs::PointCloud::descriptor());
    writer.add_attachment({5, 0, "demo.yaml", "text/yaml", "nodes: []"});
    writer.add_metadata({"run", {{"seed", "7"}}});
    for (std::uint32_t i = 1; i <= 400; ++i) {
      const std::uint64_t time = 1'000'000'000ull * 1'700'000'000 + i * 1000;
      msgs::TactileFrame frame;
      frame.mutable_header()->set_stamp(static_cast<std::int64_t>(time));
      frame.mutable_header()->set_frame_id("left_pad");
      frame.set_rows(14);
      frame.set_sum(0.25 * i);
      for (std::uint32_t texel = 0; texel < 84; ++texel) frame.add_intensity(texel * i % 4096);
      writer.write(touch, i, time, time, frame.SerializeAsString());
      if (i % 80 != 0) continue;
      msgs::PointCloud points;
      points.set_count(i);
      points.set_data(std::string(100000, static_cast<char>(i)));
      writer.write(cloud, i / 80, time + 1, time + 1, points.SerializeAsString());
    }
    writer.close();
  }

  TemporaryFolder folder_;
  static inline std::string missing_;
};

TEST_F(NpmReader, ReadsOurRecordings) {
  for (const auto& [compression, name] : {std::pair{Compression::kNone, ""},
                                          {Compression::kLz4, "lz4"},
                                          {Compression::kZstd, "zstd"}}) {
    write_recording("a.mcap", compression);
    const CommandResult result = check("read", "a.mcap");
    ASSERT_EQ(result.exit_code, 0) << result.output;
    const YAML::Node found = YAML::Load(result.output);
    EXPECT_EQ(found["messageCount"].as<int>(), 405);
    EXPECT_TRUE(found["ordered"].as<bool>());
    EXPECT_EQ(found["compressions"].size(), 1u);
    EXPECT_EQ(found["compressions"][0].as<std::string>(), name);
    const YAML::Node touch = found["topics"]["/touch"];
    EXPECT_EQ(touch["count"].as<int>(), 400);
    EXPECT_EQ(touch["schema"].as<std::string>(), "prehend.msgs.TactileFrame");
    EXPECT_EQ(touch["first"].as<std::string>(), "1700000000000001000");
    EXPECT_EQ(touch["last"].as<std::string>(), "1700000000000400000");
    EXPECT_EQ(touch["lastSequence"].as<int>(), 400);
    const YAML::Node value = touch["values"][1];
    EXPECT_EQ(value["header"]["frame_id"].as<std::string>(), "left_pad");
    EXPECT_EQ(value["header"]["stamp"].as<std::string>(), "1700000000000002000");
    EXPECT_DOUBLE_EQ(value["sum"].as<double>(), 0.5);
    EXPECT_EQ(value["intensity"][83].as<int>(), 166);
    EXPECT_EQ(found["topics"]["/cloud"]["count"].as<int>(), 5);
    EXPECT_EQ(found["topics"]["/cloud"]["values"][0]["count"].as<int>(), 80);
    EXPECT_EQ(found["attachments"][0]["text"].as<std::string>(), "nodes: []");
    EXPECT_EQ(found["metadata"][0]["entries"]["seed"].as<int>(), 7);
  }
}

TEST_F(NpmReader, StreamsOurTruncatedRecordings) {
  write_recording("a.mcap", Compression::kLz4);
  McapReader whole(folder_.file("a.mcap"));
  const McapChunkIndex& chunk = whole.chunks().back();
  write_file(folder_.file("b.mcap"),
             read_file(folder_.file("a.mcap"))
                 .substr(0, chunk.chunk_start_offset + chunk.chunk_length + 5));
  EXPECT_NE(check("read", "b.mcap").exit_code, 0) << "the indexed reader needs the footer";
  const CommandResult result = check("stream", "b.mcap");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const YAML::Node found = YAML::Load(result.output);
  EXPECT_EQ(found["types"]["Message"].as<int>(), 405);
  EXPECT_FALSE(found["done"].as<bool>());
  McapReader reader(folder_.file("b.mcap"));
  EXPECT_EQ(all_messages(reader).size(), 405u);
}

TEST_F(NpmReader, WeReadWhatTheNpmWriterWrites) {
  const CommandResult result = check("write", "a.mcap");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  McapReader reader(folder_.file("a.mcap"));
  EXPECT_TRUE(reader.problems().empty());
  EXPECT_EQ(reader.library().substr(0, 3), "npm");
  const auto messages = all_messages(reader);
  ASSERT_EQ(messages.size(), 500u);
  EXPECT_EQ(reader.statistics().message_count, 500u);
  const McapChannel& channel = reader.channels().at(messages[9].channel_id);
  EXPECT_EQ(channel.topic, "/npm");
  EXPECT_EQ(channel.metadata.at("key"), "value");
  const McapSchema* schema = reader.schema_of(channel);
  ASSERT_NE(schema, nullptr);
  const SchemaMessageFactory factory(schema->name, schema->data);
  const auto value = factory.make();
  ASSERT_TRUE(
      value->ParseFromArray(messages[9].data.data(), static_cast<int>(messages[9].data.size())));
  EXPECT_EQ(value->ShortDebugString(), "x: 4.5");
  EXPECT_EQ(messages[9].log_time, 9000u);
  EXPECT_EQ(messages[9].publish_time, 9u);
  EXPECT_EQ(reader.read_attachment(reader.attachments().at(0)).data, "attached");
  EXPECT_EQ(reader.metadata().at(0).entries.at("seed"), "7");
}

}  // namespace
}  // namespace prehend::recording
