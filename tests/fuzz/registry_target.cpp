// The registry's protocol: a sequence of requests from up to four connections, time passing between
// them. Each is `control byte | run`; bits 0 and 1 of the control byte are the connection, bit 2
// lets 2 s pass before.

#include <set>
#include <string>

#include "prehend/graph/registry_state.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/quiet_protobuf.h"

namespace {

using prehend::graph::RegistryState;
using prehend::msgs::graph::RegistryReply;

// What holds for every reply, whatever was asked.
void check(const RegistryReply& reply) {
  FUZZ_CHECK(reply.registry_instance() == "registry-of-the-fuzzer");
  std::set<std::string> names;
  for (const auto& node : reply.nodes()) {
    FUZZ_CHECK(!node.instance().empty() && !node.name().empty());
    FUZZ_CHECK(names.insert(node.name()).second);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  prehend::fuzz::quiet_protobuf();
  RegistryState state(
      {std::chrono::seconds(3), "registry-of-the-fuzzer", "/nowhere", "space-of-the-fuzzer"},
      [](const std::string&, const RegistryReply& reply) { check(reply); });
  prehend::fuzz::FuzzInput input(data, size);
  RegistryState::Time now{};
  while (!input.is_empty()) {
    const std::uint8_t control = input.byte();
    if (control & 4) {
      now += std::chrono::seconds(2);
      state.sweep(now);
    }
    state.take(std::string(1, static_cast<char>('a' + (control & 3))), input.run(), now);
  }
  now += std::chrono::seconds(10);
  state.sweep(now);
  FUZZ_CHECK(!state.sweep(now));
  return 0;
}
