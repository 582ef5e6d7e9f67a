// pg70_guardian LINE BIT_RATE MODULE PATIENCE: see guardian.h. Started by the driver's node.

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "drivers/pg70/node/guardian.h"

int main(int argc, char** argv) {
  const double patience = argc == 5 ? std::strtod(argv[4], nullptr) : 0;
  if (!(patience > 0)) {
    std::fprintf(stderr, "pg70_guardian is started by the node pg70\n");
    return 2;
  }
  ::signal(SIGINT, SIG_IGN);
  ::signal(SIGTERM, SIG_IGN);
  prehend::drivers::pg70::LinkAddress address;
  address.line = argv[1];
  address.bit_rate = static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10));
  address.module = static_cast<std::uint8_t>(std::strtoul(argv[3], nullptr, 10));
  return prehend::drivers::pg70::guard(STDIN_FILENO, address, patience);
}
