// pg70_guardian LINE BIT_RATE MODULE PATIENCE: see wire/guardian. Started by the driver's node.

#include <cstdio>
#include <cstdlib>

#include "drivers/pg70/node/gripper_guard.h"

int main(int argc, char** argv) {
  const double patience = argc == 5 ? std::strtod(argv[4], nullptr) : 0;
  if (!(patience > 0)) {
    std::fprintf(stderr, "pg70_guardian is started by the node pg70\n");
    return 2;
  }
  prehend::drivers::pg70::LinkAddress address;
  address.line = argv[1];
  address.bit_rate = static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10));
  address.module = static_cast<std::uint8_t>(std::strtoul(argv[3], nullptr, 10));
  return prehend::drivers::guard_standard_input(prehend::drivers::pg70::guarding(address),
                                                patience);
}
