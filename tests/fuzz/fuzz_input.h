#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// What a fuzzer calls with each input; every target defines it. It returns 0, or does not return:
/// a crash, a failed FUZZ_CHECK or a hang is a finding.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// Ends the program like a failed assert does, in every build type.
#define FUZZ_CHECK(condition) \
  if (!(condition)) __builtin_trap()

namespace prehend::fuzz {

/// Takes the bytes of one input apart. Numbers are little-endian; beyond the end everything is 0 or
/// empty.
class FuzzInput {
 public:
  FuzzInput(const std::uint8_t* data, std::size_t size)
      : bytes_(reinterpret_cast<const char*>(data), size) {}

  bool is_empty() const { return bytes_.empty(); }
  std::uint8_t byte() {
    const std::string_view taken = take(1);
    return taken.empty() ? std::uint8_t{0} : static_cast<std::uint8_t>(taken[0]);
  }
  /// A run of bytes, its length in front of it in two bytes.
  std::string_view run() {
    const std::size_t low = byte();
    const std::size_t high = byte();
    return take(low | high << 8);
  }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view take(std::size_t count) {
    const std::string_view taken = bytes_.substr(0, std::min(count, bytes_.size()));
    bytes_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view bytes_;
};

}  // namespace prehend::fuzz
