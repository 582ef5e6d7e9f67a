#include "drivers/dsa/codec/packet.h"

#include <stdexcept>
#include <string>

#include "drivers/wire/encoding/checksum.h"

namespace prehend::drivers::dsa {
namespace {

constexpr std::size_t kPreamble = 3, kPacketHeader = 6, kChecksum = 2;
constexpr std::uint8_t kPreambleByte = 0xAA;

}  // namespace

void append_packet(std::vector<std::uint8_t>& bytes, std::uint8_t id, Bytes payload) {
  if (payload.size() > 0xFFFF) {
    throw std::length_error("a DSA packet holds at most 65535 bytes, not " +
                            std::to_string(payload.size()));
  }
  const std::size_t begin = bytes.size();
  bytes.insert(bytes.end(), kPreamble, kPreambleByte);
  bytes.push_back(id);
  append_little(bytes, static_cast<std::uint16_t>(payload.size()));
  if (payload.empty()) return;
  append_bytes(bytes, payload);
  append_little(bytes, crc16_weiss(Bytes(bytes).subspan(begin + kPreamble)));
}

std::vector<std::uint8_t> encode_packet(std::uint8_t id, Bytes payload) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(kPacketHeader + payload.size() + kChecksum);
  append_packet(bytes, id, payload);
  return bytes;
}

void PacketDecoder::add(Bytes bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(position_));
  position_ = 0;
  append_bytes(buffer_, bytes);
}

void PacketDecoder::discard(std::size_t count) {
  position_ += count;
  discarded_ += count;
}

void PacketDecoder::give_up() {
  if (is_partial()) discard(1);
}

// Goes to the next place where a preamble stands or may begin. False: more bytes are needed.
bool PacketDecoder::find_preamble() {
  while (is_partial()) {
    std::size_t matching = 0;
    while (matching < kPreamble && position_ + matching < buffer_.size() &&
           buffer_[position_ + matching] == kPreambleByte) {
      ++matching;
    }
    if (matching == kPreamble) return true;
    if (position_ + matching == buffer_.size()) return false;
    discard(matching + 1);
  }
  return false;
}

std::optional<Packet> PacketDecoder::next() {
  while (find_preamble()) {
    const std::uint8_t* packet = buffer_.data() + position_;
    const std::size_t available = buffer_.size() - position_;
    if (available < kPacketHeader) return std::nullopt;
    const std::size_t size = load_little<std::uint16_t>(packet + 4);
    if (size > most_payload_) {
      discard(1);
      continue;
    }
    const std::size_t whole = kPacketHeader + size + (size > 0 ? kChecksum : 0);
    if (available < whole) return std::nullopt;
    if (size > 0 && crc16_weiss({packet + kPreamble, kPacketHeader - kPreamble + size}) !=
                        load_little<std::uint16_t>(packet + kPacketHeader + size)) {
      ++bad_checksums_;
      discard(1);
      continue;
    }
    position_ += whole;
    return Packet{packet[3], {packet + kPacketHeader, packet + kPacketHeader + size}};
  }
  return std::nullopt;
}

}  // namespace prehend::drivers::dsa
