#include "nodes/emergency_stop/stop_state.h"

#include <utility>

namespace prehend::nodes {
namespace {

constexpr std::size_t kMostCauses = 1000;  // a peer that invents names must not fill the memory

// Not within a character of UTF-8: what is sent must be whole.
std::string shortened(const std::string& text) {
  if (text.size() <= StopState::kLongestText) return text;
  std::size_t end = StopState::kLongestText;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end);
}

}  // namespace

bool StopState::stop(const msgs::EmergencyStopRequest& request, Time now, std::int64_t stamp) {
  // A stop without a name is a stop.
  std::string source = request.source().empty() ? "somebody" : shortened(request.source());
  std::string reason = shortened(request.reason());
  bool is_known = false;
  if (request.persists()) {
    forget_old(now);
    const auto [cause, is_new] = persisting_.try_emplace(source);
    is_known = !is_new && message_.stopped();
    cause->second = {reason, now};
    if (persisting_.size() > kMostCauses) persisting_.erase(persisting_.begin());
  }
  if (is_known) return false;
  message_.set_count(message_.count() + 1);
  if (message_.stopped()) return true;
  message_.set_stopped(true);
  message_.set_source(std::move(source));
  message_.set_reason(std::move(reason));
  message_.set_since(stamp);
  return true;
}

std::string StopState::reset(Time now) {
  forget_old(now);
  std::string causes;
  for (const auto& [source, cause] : persisting_) {
    causes += (causes.empty() ? "" : "; ") + source + ": " + cause.reason;
  }
  if (!causes.empty()) return "what caused it goes on: " + causes;
  const std::uint64_t count = message_.count();
  message_.Clear();
  message_.set_count(count);
  return "";
}

void StopState::forget_old(Time now) {
  std::erase_if(persisting_,
                [&](const auto& item) { return now - item.second.told > kPersistence; });
}

}  // namespace prehend::nodes
