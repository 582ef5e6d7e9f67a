// What a replay keeps for a reader that is slower than the recording.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>

#include "msgs/sensors.pb.h"
#include "prehend/graph/registry.h"
#include "prehend/graph/schema.h"
#include "prehend/recording/mcap_writer.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;

std::size_t resident_bytes_of(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/statm");
  std::size_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void write_large_messages(const std::string& path) {
  recording::McapWriter writer(path);
  const auto schema = graph::schema_of(*msgs::StereoPair::descriptor());
  const auto camera = writer.add_channel(
      "/stereo", "protobuf", writer.add_schema(schema->name, "protobuf", schema->descriptor_set));
  msgs::StereoPair pair;
  pair.set_data(std::string(3'000'000, '\0'));
  const std::string bytes = pair.SerializeAsString();
  for (std::uint32_t i = 1; i <= 30; ++i) {
    writer.write(camera, i, i * 20'000'000ull, i * 20'000'000ull, bytes);
  }
  writer.close();
}

// `replay --loop` grew from 57 to 330 MB: 256 MiB might wait on each topic.
TEST(ReplayMemory, ALoopForASlowReaderStaysSmall) {
  ScratchDirectory scratch;
  // Its leases outlast a stopped reader, which else would be forgotten together with what waits.
  const graph::Registry registry(
      graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*", .lease = seconds(120)});
  write_large_messages(scratch.path("a.mcap"));
  ChildProgram replay("replay",
                      {"--param", "file:=" + scratch.path("a.mcap"), "--param", "loop:=true"},
                      scratch.path("replay.txt"), registry.endpoint());
  ASSERT_TRUE(replay.wait_for_output("beginning again", seconds(30))) << replay.output();
  ChildProgram reader("prehend", {"topic", "hz", "/stereo"}, scratch.path("reader.txt"),
                      registry.endpoint());
  ASSERT_TRUE(reader.wait_for_output("messages/s", seconds(30))) << reader.output();
  const std::size_t before = resident_bytes_of(replay.pid());
  ::kill(reader.pid(), SIGSTOP);
  ASSERT_TRUE(replay.wait_for_output("a subscriber reads too slowly", seconds(60)))
      << replay.output();
  const std::size_t then = resident_bytes_of(replay.pid());
  ::kill(reader.pid(), SIGCONT);
  ::kill(replay.pid(), SIGINT);
  EXPECT_EQ(replay.wait(seconds(20)), 0) << replay.output();
  EXPECT_LT(then, before + (std::size_t{180} << 20));
}

}  // namespace
}  // namespace prehend::testing
