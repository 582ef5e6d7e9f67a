// The viewer against the public client of its protocol, the npm package @foxglove/ws-protocol.

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>

#include <gmock/gmock.h>

#include "tests/nodes/viewer_graph.h"

namespace prehend::nodes {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const std::string kFolder = "tests/viewing/npm";

struct Ran {
  int exit_code = -1;
  std::string output;
};

Ran run(const std::string& command) {
  Ran ran;
  FILE* pipe = ::popen(command.c_str(), "r");
  std::array<char, 4096> buffer;
  while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    ran.output.append(buffer.data(), got);
  }
  const int status = ::pclose(pipe);
  if (WIFEXITED(status)) ran.exit_code = WEXITSTATUS(status);
  return ran;
}

class ViewerNpmTest : public ViewerGraph {
 protected:
  void SetUp() override {
    if (run("node --version 2>/dev/null").exit_code != 0) GTEST_SKIP() << "node is not installed";
    const auto installed = [] {
      for (const char* name : {"@foxglove/ws-protocol", "@foxglove/schemas", "protobufjs", "ws"}) {
        if (!std::filesystem::exists(kFolder + "/node_modules/" + name)) return false;
      }
      return true;
    };
    if (!installed()) run("cd " + kFolder + " && timeout 60 npm ci --no-audit --no-fund 2>&1");
    if (!installed()) {
      GTEST_SKIP() << "the npm packages are missing: run npm ci in " << kFolder;
    }
  }
};

TEST_F(ViewerNpmTest, ThePublicClientUnderstandsEverything) {
  start_viewer();
  const Ran ran =
      run("timeout 60 node " + kFolder + "/check.cjs " + std::to_string(port()) + " 2>&1");
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  EXPECT_THAT(ran.output, HasSubstr("ok every schema is decodable"));
  EXPECT_THAT(heard(), Contains("hello")) << "what the client published";
}

}  // namespace
}  // namespace prehend::nodes
