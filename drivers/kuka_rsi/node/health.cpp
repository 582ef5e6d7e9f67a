#include "drivers/kuka_rsi/node/health.h"

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

}  // namespace prehend::drivers::kuka_rsi
