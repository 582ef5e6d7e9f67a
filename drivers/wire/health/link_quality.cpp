#include "drivers/wire/health/link_quality.h"

#include <cstdio>

namespace prehend::drivers {
namespace {

constexpr double kLeastSpan = 2;           // s, before anything is said of rates
constexpr std::uint64_t kLeastHarmed = 3;  // one or two are what any line may do

}  // namespace

void LinkQuality::sample(std::uint64_t good, std::uint64_t harmed, double rate, Time now) {
  if (rate != wanted_rate_) samples_.clear();
  wanted_rate_ = rate;
  samples_.push_back({now, good, harmed});
  while (samples_.size() > 2 && now - samples_[1].time >= to_time(kWindow)) samples_.pop_front();
}

double LinkQuality::span() const {
  return samples_.size() < 2 ? 0 : to_seconds(samples_.back().time - samples_.front().time);
}

double LinkQuality::harmed_part() const {
  if (samples_.size() < 2) return 0;
  const auto harmed = samples_.back().harmed - samples_.front().harmed;
  const auto all = harmed + samples_.back().good - samples_.front().good;
  return all == 0 ? 0 : static_cast<double>(harmed) / static_cast<double>(all);
}

double LinkQuality::rate() const {
  const double seconds = span();
  if (seconds <= 0) return 0;
  return static_cast<double>(samples_.back().good - samples_.front().good) / seconds;
}

std::string LinkQuality::problem() const {
  if (samples_.size() < 2) return {};
  char text[160];
  const auto harmed = samples_.back().harmed - samples_.front().harmed;
  if (harmed >= kLeastHarmed && harmed_part() > kMostHarmed) {
    std::snprintf(text, sizeof text,
                  "the line is bad: %.0f %% of its messages are damaged or lost. Check plugs, "
                  "shielding and termination",
                  100 * harmed_part());
    return text;
  }
  if (span() >= kLeastSpan && rate() < kLeastRate * wanted_rate_) {
    std::snprintf(text, sizeof text,
                  "only %.0f of %.0f messages a second come. Check the line and the load of this "
                  "computer",
                  rate(), wanted_rate_);
    return text;
  }
  return {};
}

}  // namespace prehend::drivers
