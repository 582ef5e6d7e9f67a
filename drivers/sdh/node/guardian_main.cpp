// sdh_guardian LINE BAUD PATIENCE: see wire/guardian. Started by the driver's node.

#include "drivers/sdh/node/hand_guard.h"

int main(int argc, char** argv) {
  using namespace prehend::drivers;
  return guard_by_words(argc, argv, 2, [](const std::vector<std::string>& words) {
    return sdh::guarding(words[0], number_of(words[1]));
  });
}
