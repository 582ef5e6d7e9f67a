// barrett_guardian BUS BIT_RATE PATIENCE: see wire/guardian. Started by the driver's node.

#include <cstdio>
#include <cstdlib>

#include "drivers/barrett/node/hand_guard.h"

int main(int argc, char** argv) {
  const double patience = argc == 4 ? std::strtod(argv[3], nullptr) : 0;
  if (!(patience > 0)) {
    std::fprintf(stderr, "barrett_guardian is started by the node barrett\n");
    return 2;
  }
  const auto bit_rate = static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10));
  return prehend::drivers::guard_standard_input(
      prehend::drivers::barrett::guarding(argv[1], bit_rate), patience);
}
