// barrett_guardian can BUS BIT_RATE 0 PATIENCE, or gcl LINE BAUD FAST_BAUD PATIENCE: see
// wire/guardian. Started by the driver's node.

#include "drivers/barrett/node/hand_guard.h"

int main(int argc, char** argv) {
  using namespace prehend::drivers;
  return guard_by_words(argc, argv, 4, [](const std::vector<std::string>& words) {
    return words[0] == barrett::kByLine
               ? barrett::gcl::guarding(words[1], number_of(words[2]), number_of(words[3]))
               : barrett::guarding(words[1], number_of(words[2]));
  });
}
