#include "prehend/simulation/state_frame.h"

#include <cstdint>

#include "prehend/simulation/state_bytes.h"

namespace prehend::simulation {
namespace {

constexpr std::uint32_t kVersion = 2;

std::string first_line(std::string_view kind) { return "prehend " + std::string(kind) + "\n"; }

}  // namespace

std::string framed(std::string_view kind, std::string_view payload) {
  StateWriter head;
  head(kVersion, static_cast<std::uint64_t>(payload.size()));
  std::string bytes = first_line(kind) + head.bytes();
  bytes += payload;
  StateWriter tail;
  tail(fingerprint(bytes));
  return bytes + tail.bytes();
}

std::string_view unframed(std::string_view kind, std::string_view bytes, const std::string& what) {
  const std::string line = first_line(kind);
  if (bytes.substr(0, line.size()) != line) {
    throw geometry::InputError(what + " is no " + std::string(kind) + " of prehend",
                               "Give one that World wrote");
  }
  StateReader head(bytes.substr(line.size()), what);
  std::uint32_t version = 0;
  std::uint64_t size = 0, checksum = 0;
  head(version);
  if (version != kVersion) {
    throw geometry::InputError(what + " has version " + std::to_string(version) +
                                   "; this program reads version " + std::to_string(kVersion),
                               "Save it with this program");
  }
  head(size);
  if (head.left() < sizeof checksum || head.left() - sizeof checksum < size) {
    head.fail("ends in the middle: it was cut off");
  }
  if (head.left() - sizeof checksum > size) head.fail("goes on after its end");
  const std::size_t covered = bytes.size() - sizeof checksum;
  StateReader(bytes.substr(covered), what)(checksum);
  if (checksum != fingerprint(bytes.substr(0, covered))) head.fail("is damaged: checksum");
  return bytes.substr(covered - size, size);
}

}  // namespace prehend::simulation
