#include "drivers/kuka_rsi/driver/probe.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "drivers/kuka_rsi/codec/xml_reader.h"
#include "drivers/kuka_rsi/transport/udp_socket.h"

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr int kEnough = 5;  // telegrams

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", value);
  return text.data();
}

Probe lacking(const std::string& who, const std::string& what, const std::string& mend) {
  return {Probe::Result::kWarns, who + " sends, but " + what, mend};
}

}  // namespace

Probe probe(const std::string& host, int port, const TelegramNames& names, double seconds) {
  UdpSocket socket(host, port);
  std::array<char, 2 * XmlReader::kLongestText> buffer{};
  const Time end = steady_now() + to_time(seconds);
  RobotTelegram telegram;
  const char* why = "";
  std::string damage, who;
  std::optional<Time> first;
  Time last{};
  int good = 0;
  while (good < kEnough) {
    const auto datagram = socket.receive(buffer, end);
    if (!datagram.came) break;
    who = "controller at " + datagram.peer.name();
    const TelegramResult result = read_robot_telegram(datagram.bytes, names, telegram, why);
    if (result == TelegramResult::kWrong) damage = why;
    if (result != TelegramResult::kGood) continue;
    if (!first) first = datagram.arrived;
    last = datagram.arrived;
    ++good;
  }
  if (who.empty()) {
    return {Probe::Result::kSilent, "no controller sends to UDP " + socket.here().name(),
            "start its RSI program; IP_NUMBER and PORT of its RSI_EthernetConfig name this "
            "machine; a firewall lets UDP " +
                std::to_string(port) + " in"};
  }
  if (good == 0) {
    return {Probe::Result::kSilent, who + " sends no telegrams of RSI: " + damage,
            "another program sends there, or its elements have other names"};
  }
  if (!telegram.actual_axes || !telegram.delay) {
    return lacking(who, "not " + std::string(telegram.actual_axes ? "Delay" : "the actual axes"),
                   "add DEF_AIPos and DEF_Delay to SEND of its RSI_EthernetConfig");
  }
  if (!telegram.commanded_axes) {
    return lacking(who, "not the programmed axes, so that a gap cannot be told from a restart",
                   "add DEF_ASPos to SEND of its RSI_EthernetConfig");
  }
  std::string axes;
  for (const double degrees : *telegram.actual_axes) axes += " " + text_of(degrees);
  const double cycle = good > 1 ? to_seconds(last - *first) / (good - 1) : 0;
  return {Probe::Result::kAnswers,
          who + " sends every " + text_of(cycle * 1e3) + " ms: axes at" + axes + " degrees",
          {}};
}

}  // namespace prehend::drivers::kuka_rsi
