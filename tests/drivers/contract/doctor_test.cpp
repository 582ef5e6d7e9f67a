// prehend doctor names what is wrong with a device's line, and the mend.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/wire/can/can_interface.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "prehend/graph/registry.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class DriversDoctor : public ::testing::Test {
 protected:
  /// Its page once it holds `text`, with the program running beside.
  std::string page_of(const std::string& program, const std::vector<std::string>& parameters,
                      const std::string& text) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.push_back("--param");
      arguments.push_back(parameter);
    }
    const testing::Launched driver(program, arguments, scratch_.path() / (program + ".txt"));
    std::string page;
    eventually(
        [&] {
          page = testing::run_program("prehend", {"doctor", "--registry", registry_.endpoint()},
                                      std::chrono::seconds(20))
                     .output;
          return page.find(text) != std::string::npos;
        },
        std::chrono::seconds(30));
    return page;
  }

  testing::ScratchFolder scratch_;
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
};

TEST_F(DriversDoctor, NamesTheMissingCanInterface) {
  const char* words =
      kernel_has_can() ? "there is no CAN interface can_none" : "this kernel offers no CAN sockets";
  const char* mend = kernel_has_can() ? "plug the adapter in" : "sudo modprobe can-raw";
  EXPECT_THAT(page_of("pg70", {"can:=can_none"}, words), AllOf(HasSubstr(words), HasSubstr(mend)));
}

TEST_F(DriversDoctor, NamesTheModuleThatDoesNotAnswer) {
  const PseudoTerminal nobody;
  EXPECT_THAT(page_of("pg70", {"can:=slcan:" + nobody.name(), "module_id:=13"}, "module 13"),
              AllOf(HasSubstr("module 13 does not answer on slcan:"),
                    HasSubstr("Check its supply, wiring and termination")));
}

TEST_F(DriversDoctor, NamesLinesThatCannotBeOpened) {
  EXPECT_THAT(page_of("dsa", {"line:=/dev/no_pads"}, "/dev/no_pads"),
              AllOf(HasSubstr("cannot open /dev/no_pads"), HasSubstr("ls /dev/serial/by-id")));
  EXPECT_THAT(page_of("ft300", {"line:=/dev/no_sensor"}, "/dev/no_sensor"),
              AllOf(HasSubstr("cannot open /dev/no_sensor"), HasSubstr("ls /dev/serial/by-id")));
}

TEST_F(DriversDoctor, StatesThatDoNotFitTheLineAreRefusedAtTheStart) {
  const auto outcome = testing::run_program(
      "pg70", {"--registry", registry_.endpoint(), "--param", "can:=serial:/dev/ttyS9"},
      std::chrono::seconds(20));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("a state every 0.02 s is too much for 9600 baud"),
                                    HasSubstr("Set state_period to at least 0.030")));
}

}  // namespace
}  // namespace prehend::drivers
