#include "drivers/pg70/transport/link.h"

#include <array>
#include <atomic>
#include <utility>

#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/codec/serial_framing.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::pg70 {
namespace {

using std::chrono::steady_clock;

LinkEvent event_of(const CanEvent& event) {
  switch (event.kind) {
    case CanEvent::Kind::kBusOff:
    case CanEvent::Kind::kInterfaceDown:
      return {LinkEvent::Kind::kDown, event.words};
    case CanEvent::Kind::kRestarted:
      return {LinkEvent::Kind::kUp, event.words};
    case CanEvent::Kind::kClosed:
      return {LinkEvent::Kind::kClosed, event.words};
    default:
      return {LinkEvent::Kind::kDisturbed, event.words};
  }
}

class CanLink : public Link {
 public:
  CanLink(std::unique_ptr<CanBus> bus, std::uint8_t module, Side side)
      : bus_(std::move(bus)), module_(module), side_(side) {}

  std::optional<LinkInput> receive(std::chrono::nanoseconds timeout) override {
    const auto end = steady_clock::now() + timeout;
    while (true) {
      const auto left = std::max(end - steady_clock::now(), steady_clock::duration::zero());
      auto input = bus_->receive(left);
      if (!input) return std::nullopt;
      if (const auto* event = std::get_if<CanEvent>(&*input)) return event_of(*event);
      const auto& frame = std::get<CanFrame>(*input);
      const auto direction = can_direction(frame.identifier);
      if (!direction || (frame.identifier & 0xFF) != module_) continue;
      if ((*direction == Direction::kCommand) != (side_ == Side::kModule)) continue;
      FrameAssembler& assembler = *direction == Direction::kError ? errors_ : messages_;
      auto content = assembler.add(frame);
      damaged_ = messages_.broken() + errors_.broken();
      if (content) return Incoming{*direction, *content};
    }
  }

  std::string send(Direction direction, const Content& content) override {
    if (side_ == Side::kMaster) direction = Direction::kCommand;
    std::string problem;
    split_into_frames(can_identifier(direction, module_), content, [&](const CanFrame& frame) {
      if (problem.empty()) problem = bus_->send(frame);
    });
    return problem;
  }

  const std::string& name() const override { return bus_->name(); }
  std::uint64_t damaged() const override { return damaged_; }

 private:
  std::unique_ptr<CanBus> bus_;
  std::uint8_t module_;
  Side side_;
  FrameAssembler messages_, errors_;  // of the identifiers 0x700 (or 0x500) and 0x300
  std::atomic<std::uint64_t> damaged_ = 0;
};

class SerialLink : public Link {
 public:
  SerialLink(std::unique_ptr<ByteStream> stream, std::uint8_t module, Side side,
             std::chrono::nanoseconds gap)
      : stream_(std::move(stream)), module_(module), side_(side), gap_(gap) {}

  std::optional<LinkInput> receive(std::chrono::nanoseconds timeout) override {
    if (auto incoming = next()) return *incoming;
    std::array<std::uint8_t, 512> buffer;
    const IoResult result = stream_->read(buffer, timeout);
    if (result.status == IoStatus::kClosed) {
      return LinkEvent{LinkEvent::Kind::kClosed, stream_->name() + " is gone: " + result.problem};
    }
    if (result.count > 0) {
      last_byte_ = steady_now();
      decoder_.add(Bytes(buffer).first(result.count));
    } else if (decoder_.is_partial() && steady_now() - last_byte_ > gap_) {
      decoder_.give_up();
    }
    auto incoming = next();
    if (const auto discarded = decoder_.discarded(); discarded != discarded_) {
      discarded_ = discarded;
      ++damaged_;
    }
    if (incoming) return *incoming;
    return std::nullopt;
  }

  std::string send(Direction direction, const Content& content) override {
    constexpr auto kWriteTime = std::chrono::milliseconds(20);
    if (side_ == Side::kMaster) direction = Direction::kCommand;
    const IoResult result =
        stream_->write(encode_serial({direction, module_, content}), kWriteTime);
    return result.status == IoStatus::kOk ? std::string() : stream_->name() + ": " + result.problem;
  }

  const std::string& name() const override { return stream_->name(); }
  std::uint64_t damaged() const override { return damaged_; }

 private:
  std::optional<Incoming> next() {
    while (auto message = decoder_.next()) {
      if (message->module != module_) continue;
      // A master hears its own commands on a two-wire line.
      if ((message->direction == Direction::kCommand) != (side_ == Side::kModule)) continue;
      return Incoming{message->direction, message->content};
    }
    return std::nullopt;
  }

  std::unique_ptr<ByteStream> stream_;
  std::uint8_t module_;
  Side side_;
  std::chrono::nanoseconds gap_;
  SerialDecoder decoder_;
  std::uint64_t discarded_ = 0;  // bytes
  Time last_byte_{};
  std::atomic<std::uint64_t> damaged_ = 0;
};

}  // namespace

std::unique_ptr<Link> make_can_link(std::unique_ptr<CanBus> bus, std::uint8_t module, Side side) {
  return std::make_unique<CanLink>(std::move(bus), module, side);
}

std::unique_ptr<Link> make_serial_link(std::unique_ptr<ByteStream> stream, std::uint8_t module,
                                       Side side, std::chrono::nanoseconds gap) {
  return std::make_unique<SerialLink>(std::move(stream), module, side, gap);
}

std::unique_ptr<Link> open_link(const LinkAddress& address) {
  constexpr std::string_view kSerial = "serial:";
  if (address.line.starts_with(kSerial)) {
    return make_serial_link(
        open_byte_stream(address.line.substr(kSerial.size()),
                         address.bit_rate > 0 ? address.bit_rate : kFactoryBaud),
        address.module, Side::kMaster);
  }
  return make_can_link(open_can_bus(address.line, address.bit_rate,
                                    {can_identifier(Direction::kResponse, address.module),
                                     can_identifier(Direction::kError, address.module)}),
                       address.module, Side::kMaster);
}

}  // namespace prehend::drivers::pg70
