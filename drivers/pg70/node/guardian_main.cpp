// pg70_guardian LINE BIT_RATE MODULE PATIENCE: see wire/guardian. Started by the driver's node.

#include "drivers/pg70/node/gripper_guard.h"

int main(int argc, char** argv) {
  using namespace prehend::drivers;
  return guard_by_words(argc, argv, 3, [](const std::vector<std::string>& words) {
    return pg70::guarding(
        {words[0], number_of(words[1]), static_cast<std::uint8_t>(number_of(words[2]))});
  });
}
