#include "drivers/pg70/driver/probe.h"

#include <array>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"
#include "drivers/pg70/codec/serial_framing.h"
#include "drivers/wire/can/can_interface.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr std::string_view kSerial = "serial:";
constexpr auto kListening = std::chrono::milliseconds(150);  // longer than the period of states
constexpr int kTries = 3;

/// All that is said on a line, whichever module says it.
class Ear {
 public:
  virtual ~Ear() = default;
  /// Takes in what comes within `time`; ends early when `module` (0: nobody) is heard.
  void listen(std::chrono::nanoseconds time, std::uint8_t module) {
    const Time end = steady_now() + time;
    for (Time now = steady_now(); now < end && !is_gone && !said.contains(module);) {
      receive(end - now);
      now = steady_now();
    }
  }
  virtual std::string send(std::uint8_t module, const Content& content) = 0;
  /// Time from one request to the next that the wire can bear.
  virtual std::chrono::nanoseconds message_time() const = 0;

  std::map<std::uint8_t, Content> said;  // the last message of each module
  std::uint64_t others = 0;              // frames, or bytes, that no module said
  std::string trouble;                   // of the line, in words
  bool is_gone = false;                  // nothing comes on it any more

 private:
  virtual void receive(std::chrono::nanoseconds timeout) = 0;
};

class CanEar : public Ear {
 public:
  explicit CanEar(std::unique_ptr<CanBus> bus) : bus_(std::move(bus)) {}
  std::string send(std::uint8_t module, const Content& content) override {
    std::string problem;
    split_into_frames(can_identifier(Direction::kCommand, module), content,
                      [&](const CanFrame& frame) {
                        if (problem.empty()) problem = bus_->send(frame);
                      });
    return problem;
  }
  std::chrono::nanoseconds message_time() const override { return std::chrono::milliseconds(3); }

 private:
  void receive(std::chrono::nanoseconds timeout) override {
    const auto input = bus_->receive(timeout);
    if (!input) return;
    if (const auto* event = std::get_if<CanEvent>(&*input)) {
      trouble = event->kind == CanEvent::Kind::kRestarted ? "" : event->words;
      is_gone = event->kind == CanEvent::Kind::kClosed;
      return;
    }
    const auto& frame = std::get<CanFrame>(*input);
    const auto direction = can_direction(frame.identifier);
    const auto module = static_cast<std::uint8_t>(frame.identifier & 0xFF);
    if (direction == Direction::kCommand) return;  // of another program on this computer
    if (!direction || module == 0) {
      ++others;
    } else if (auto content = assemblers_[frame.identifier].add(frame)) {
      said[module] = *content;
    }
  }

  std::unique_ptr<CanBus> bus_;
  std::map<std::uint16_t, FrameAssembler> assemblers_;
};

class SerialEar : public Ear {
 public:
  SerialEar(std::unique_ptr<ByteStream> stream, unsigned baud)
      : stream_(std::move(stream)), baud_(baud) {}
  std::string send(std::uint8_t module, const Content& content) override {
    const IoResult result = stream_->write(encode_serial({Direction::kCommand, module, content}),
                                           std::chrono::milliseconds(50));
    return result.status == IoStatus::kOk ? std::string() : stream_->name() + ": " + result.problem;
  }
  std::chrono::nanoseconds message_time() const override {
    constexpr double kBits = 11 * 10;  // of a request; replies take the other wire meanwhile
    return std::chrono::milliseconds(1) + to_time(kBits / baud_);
  }

 private:
  void receive(std::chrono::nanoseconds timeout) override {
    std::array<std::uint8_t, 512> buffer;
    const IoResult result = stream_->read(buffer, timeout);
    if (result.status == IoStatus::kClosed) {
      trouble = stream_->name() + " is gone: " + result.problem;
      is_gone = true;
    }
    decoder_.add(Bytes(buffer).first(result.count));
    while (const auto message = decoder_.next()) {
      if (message->direction != Direction::kCommand) said[message->module] = message->content;
    }
    others = decoder_.discarded();
  }

  std::unique_ptr<ByteStream> stream_;
  unsigned baud_;
  SerialDecoder decoder_;
};

std::unique_ptr<Ear> open_ear(const LinkAddress& address) {
  if (!address.line.starts_with(kSerial)) {
    return std::make_unique<CanEar>(open_can_bus(address.line, address.bit_rate, {}));
  }
  const unsigned baud = address.bit_rate > 0 ? address.bit_rate : kFactoryBaud;
  return std::make_unique<SerialEar>(open_byte_stream(address.line.substr(kSerial.size()), baud),
                                     baud);
}

// With the mode of the driver, so that one that runs is not left with another.
Content question() { return encode(GetState{GetState::Cycle{0, kWithAll}}); }

Probe answered(const std::string& who, const Content& content) {
  const Response response = decode_response(content, kWithAll);
  Probe probe{Probe::Result::kAnswers, who + " answers", {}};
  std::uint8_t code = 0;
  if (const auto* fault = std::get_if<Fault>(&response)) {
    code = static_cast<std::uint8_t>(fault->code);
  } else if (const auto* refusal = std::get_if<Refusal>(&response)) {
    code = static_cast<std::uint8_t>(refusal->reason);
  }
  if (const auto* state = std::get_if<State>(&response)) {
    std::ostringstream words;
    if (state->position) words << ", at " << *state->position << " of its units";
    if (state->status & kMoving) words << ", moving";
    probe.what += words.str();
    code = state->error;
    if (code == 0 && !(state->status & kReferenced)) {
      probe.result = Probe::Result::kWarns;
      probe.what += ", but is not referenced";
      probe.mend =
          "with nothing between its jaws and the driver running: prehend service call "
          "/gripper/reference";
    }
  }
  if (code == 0) return probe;
  probe.result = Probe::Result::kWarns;
  probe.what += " with " + describe_code(code);
  probe.mend =
      "take the cause away; then, with the driver running: prehend service call "
      "/gripper/acknowledge";
  return probe;
}

std::string list_of(const std::map<std::uint8_t, Content>& modules) {
  std::string text;
  for (const auto& [module, content] : modules) {
    text += (text.empty() ? "" : ", ") + std::to_string(module);
  }
  return text;
}

// The state that the kernel knows of a CAN controller.
std::string controller_state(const std::string& line) {
  if (line.find(':') != std::string::npos) return {};
  const auto interface = find_can_interface(line);
  return interface ? interface->state : std::string();
}

Probe silent(const LinkAddress& address, const Ear& ear, const std::string& send_problem) {
  const std::string& line = address.line;
  Probe probe{Probe::Result::kSilent,
              "module " + std::to_string(address.module) + " does not answer on " + line,
              "check its supply (24 V) and wiring"};
  const bool is_can = !line.starts_with(kSerial);
  if (controller_state(line) == "bus-off") {
    probe.what += "; the interface is off the bus after too many errors";
    probe.mend = "check termination, wiring and bit rate, then: sudo ip link set " + line +
                 " type can restart";
  } else if (!ear.said.empty()) {
    probe.what += ", but " + list_of(ear.said) + " does";
    probe.mend = "module_id:=" + std::to_string(ear.said.begin()->first) +
                 ", or give the module its id with Schunk's program";
  } else if (!ear.trouble.empty() || !send_problem.empty()) {
    probe.what += "; " + (ear.trouble.empty() ? send_problem : ear.trouble);
    probe.mend += is_can
                      ? ", 120 Ohm at both ends of the bus, and that the bit rate is the module's"
                      : ", and the adapter's plug";
  } else if (ear.others > 0) {
    probe.what += is_can ? "; others talk on the bus" : "; what comes is no message of a module";
    probe.mend += is_can ? ", and its id: --scan asks all"
                         : ", the baud rate, and that this is the module's line";
  } else {
    probe.what += ", and nothing else is heard";
    probe.mend += is_can ? ", the bus' termination and bit rate, and its id: --scan asks all"
                         : " (RXD and TXD crossed), the baud rate, and its id: --scan asks all";
  }
  return probe;
}

}  // namespace

Probe probe(const LinkAddress& address, std::chrono::nanoseconds patience) {
  const auto ear = open_ear(address);
  ear->listen(kListening, address.module);
  std::string problem;
  for (int i = 0; i < kTries && !ear->is_gone && !ear->said.contains(address.module); ++i) {
    problem = ear->send(address.module, question());
    ear->listen(patience, address.module);
  }
  const auto found = ear->said.find(address.module);
  if (found == ear->said.end()) return silent(address, *ear, problem);
  return answered("module " + std::to_string(address.module) + " on " + address.line,
                  found->second);
}

OtherTraffic listen(const LinkAddress& address) {
  constexpr auto kSecond = std::chrono::seconds(1);
  const auto ear = open_ear(address);
  ear->listen(kSecond, 0);
  OtherTraffic traffic;
  for (const auto& [module, content] : ear->said) traffic.modules.insert(module);
  traffic.others = ear->others;
  return traffic;
}

std::set<std::uint8_t> find_modules(const LinkAddress& address) {
  constexpr auto kLast = std::chrono::milliseconds(200);  // for slow answers
  const auto ear = open_ear(address);
  ear->listen(kListening, 0);
  for (unsigned module = 1; module <= 255; ++module) {
    const auto id = static_cast<std::uint8_t>(module);
    if (ear->said.contains(id)) continue;
    ear->send(id, question());  // what cannot be sent is not answered, either
    ear->listen(ear->message_time(), 0);
  }
  ear->listen(kLast, 0);
  std::set<std::uint8_t> modules;
  for (const auto& [module, content] : ear->said) modules.insert(module);
  return modules;
}

}  // namespace prehend::drivers::pg70
