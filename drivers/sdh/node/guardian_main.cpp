// sdh_guardian LINE BAUD PATIENCE: see wire/guardian. Started by the driver's node.

#include <cstdio>
#include <cstdlib>

#include "drivers/sdh/node/hand_guard.h"

int main(int argc, char** argv) {
  const double patience = argc == 4 ? std::strtod(argv[3], nullptr) : 0;
  if (!(patience > 0)) {
    std::fprintf(stderr, "sdh_guardian is started by the node sdh\n");
    return 2;
  }
  const auto baud = static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10));
  return prehend::drivers::guard_standard_input(prehend::drivers::sdh::guarding(argv[1], baud),
                                                patience);
}
