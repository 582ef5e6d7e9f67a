#include "drivers/kuka_rsi/node/health.h"

#include <utility>

namespace prehend::drivers::kuka_rsi {
namespace {

const char* mend_of(Reason refusal) {
  switch (refusal) {
    case Reason::kNoSignals:
      return "add DEF_AIPos and DEF_Delay to SEND of its RSI_EthernetConfig";
    case Reason::kCorrected:
      return "its program has to switch RSI on where it stands, with absolute corrections";
    case Reason::kCycle:
      return "set cycle (rsi_cycle:=) to the controller's, 4 or 12 ms";
    default:
      return "it ends RSI by itself; start its program again";
  }
}

}  // namespace

Health health_of(const Snapshot& now, const std::string& peer, const std::string& trouble,
                 const std::string& missing_real_time, int port) {
  Health health;
  switch (now.state) {
    case State::kSilent:
      health = {Health::Level::kError,
                "no controller sends to UDP port " + std::to_string(port) +
                    (peer.empty() ? std::string() : "; the last was " + peer) +
                    ". Start its RSI program"};
      break;
    case State::kRefused:
      health = {Health::Level::kError, "controller " + peer + " is not answered: " +
                                           to_string(now.refusal) + ". " + mend_of(now.refusal)};
      break;
    default:
      health.words = std::string(to_string(now.state)) + ", controller " + peer;
  }
  health = with_warning(health, now.latched ? "stopped; /arm/acknowledge ends that" : "");
  health = with_warning(health, trouble);
  return with_warning(health, missing_real_time);
}

std::string OwnStops::look(const Snapshot& now, const std::string& peer) {
  const std::uint64_t before = std::exchange(sessions_, now.sessions);
  const bool has_left = now.reason == Reason::kOffPath && now.ticket != ticket_;
  if (has_left) ticket_ = now.ticket;
  if (now.sessions == 0) return {};
  if (now.state == State::kSilent) {
    return "RSI has ended at controller " + peer +
           ", by its program, its emergency stop or the network";
  }
  if (now.state == State::kRefused) {
    return "controller " + peer + " is not answered: " + to_string(now.refusal);
  }
  if (before != 0 && now.sessions != before) {
    return "RSI ended at controller " + peer + " and began again";
  }
  return has_left ? "the arm of controller " + peer + " left its path" : std::string();
}

}  // namespace prehend::drivers::kuka_rsi
