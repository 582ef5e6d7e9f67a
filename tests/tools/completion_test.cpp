// Shell completion: the script, sourced by bash, against a running graph.

#include <gmock/gmock.h>
#include <stdlib.h>

#include <array>
#include <cstdio>
#include <sstream>

#include "tests/tools/command_fixture.h"

namespace prehend::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;

class Completion : public Command {
 protected:
  // What bash offers for the last of `words` behind "prehend".
  std::vector<std::string> offered(const std::vector<std::string>& words) {
    const std::string program = std::string(std::getenv("PREHEND_BIN")) + "/prehend";
    std::string line = "COMP_WORDS=('" + program + "'";
    for (const std::string& word : words) line += " '" + word + "'";
    const std::string script = scratch_.write(
        "complete.sh", "source <('" + program + "' completion bash)\n" + line +
                           ")\nCOMP_CWORD=" + std::to_string(words.size()) +
                           "\n_prehend\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n"
                           "complete -p prehend | grep -q _prehend || echo NOT REGISTERED\n");
    std::unique_ptr<FILE, int (*)(FILE*)> pipe(
        ::popen(("PREHEND_REGISTRY=" + registry_.endpoint() + " bash --norc " + script).c_str(),
                "r"),
        ::pclose);
    std::string text;
    std::array<char, 4096> block{};
    while (const std::size_t got = std::fread(block.data(), 1, block.size(), pipe.get())) {
      text.append(block.data(), got);
    }
    std::istringstream lines(text);
    std::vector<std::string> result;
    while (std::getline(lines, line)) {
      if (!line.empty()) result.push_back(line);
    }
    return result;
  }
};

TEST_F(Completion, OffersCommandsAndOptions) {
  EXPECT_THAT(offered({""}), IsSupersetOf({"node", "topic", "service", "action", "param", "log",
                                           "graph", "doctor", "launch", "bag", "completion"}));
  EXPECT_THAT(offered({""}), Not(Contains("__complete")));
  EXPECT_THAT(offered({"top"}), ElementsAre("topic"));
  EXPECT_THAT(offered({"topic", ""}),
              ElementsAre("bw", "delay", "echo", "hz", "info", "list", "pub"));
  EXPECT_THAT(offered({"topic", "hz", "--d"}), ElementsAre("--duration"));
  EXPECT_THAT(offered({"log", "--level", "w"}), ElementsAre("warning"));
  EXPECT_THAT(offered({"nonsense", ""}), Not(IsEmpty())) << "as before a command";
}

TEST_F(Completion, OffersNamesOfTheRunningGraph) {
  EXPECT_THAT(offered({"topic", "echo", "/cam"}), ElementsAre("/camera/stereo"));
  EXPECT_THAT(offered({"topic", "hz", "--duration", "2", "/gr"}), ElementsAre("/gripper/command"));
  EXPECT_THAT(offered({"node", "info", ""}), ElementsAre("arm"));
  EXPECT_THAT(offered({"log", "--node", ""}), ElementsAre("arm"));
  EXPECT_THAT(offered({"service", "call", "/"}), ElementsAre("/add_one"));
  EXPECT_THAT(offered({"action", "send", ""}), ElementsAre("/count"));
  EXPECT_THAT(offered({"param", "get", "arm", "s"}), ElementsAre("speed"));
  EXPECT_THAT(offered({"param", "get", "nobody", "s"}), IsEmpty());
  EXPECT_THAT(offered({"topic", "echo", "--registry", "tcp://127.0.0.1:9", "/"}), IsEmpty());
}

TEST_F(Completion, OffersLaunchFiles) {
  EXPECT_THAT(offered({"launch", "launch/de"}), ElementsAre("launch/demo.yaml"));
  EXPECT_THAT(offered({"launch", "/none/"}), IsEmpty());
}

TEST_F(Completion, ScriptsAreForKnownShells) {
  EXPECT_EQ(run({"completion", "zsh"}).exit_code, 0);
  const Result other = run({"completion", "fish"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.output, ::testing::HasSubstr("bash and zsh"));
  EXPECT_EQ(run({"__complete"}).exit_code, 0);
}

}  // namespace
}  // namespace prehend::testing
