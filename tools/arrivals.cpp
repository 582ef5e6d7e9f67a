#include "tools/arrivals.h"

#include <algorithm>
#include <cmath>

namespace prehend::tools {
namespace {

// Gathers values one by one; the variance by Welford's recurrence, which does not cancel.
class Gathering {
 public:
  void add(double value) {
    spread_.least = spread_.count == 0 ? value : std::min(spread_.least, value);
    spread_.greatest = spread_.count == 0 ? value : std::max(spread_.greatest, value);
    ++spread_.count;
    const double before = value - spread_.mean;
    spread_.mean += before / static_cast<double>(spread_.count);
    squares_ += before * (value - spread_.mean);
  }
  Spread spread() const {
    Spread result = spread_;
    if (result.count > 0) {
      result.deviation = std::sqrt(std::max(0.0, squares_ / static_cast<double>(result.count)));
    }
    return result;
  }

 private:
  Spread spread_;
  double squares_ = 0;
};

}  // namespace

void Arrivals::add(const Arrival& arrival) {
  ++total_;
  arrivals_.push_back(arrival);
  if (arrivals_.size() > window_) arrivals_.pop_front();
}

double Arrivals::span() const {
  return arrivals_.size() < 2 ? 0 : arrivals_.back().time - arrivals_.front().time;
}

double Arrivals::rate() const {
  return span() > 0 ? static_cast<double>(arrivals_.size() - 1) / span() : 0;
}

double Arrivals::bytes_per_second() const {
  double sum = 0;  // the first one came at the beginning of the span
  for (std::size_t i = 1; i < arrivals_.size(); ++i) sum += arrivals_[i].bytes;
  return span() > 0 ? sum / span() : 0;
}

Spread Arrivals::intervals() const {
  Gathering gathering;
  for (std::size_t i = 1; i < arrivals_.size(); ++i) {
    gathering.add(arrivals_[i].time - arrivals_[i - 1].time);
  }
  return gathering.spread();
}

Spread Arrivals::bytes() const {
  return spread_of([](const Arrival& arrival) { return arrival.bytes; });
}

Spread Arrivals::delays() const {
  return spread_of([](const Arrival& arrival) { return arrival.delay; });
}

Spread Arrivals::spread_of(const std::function<double(const Arrival&)>& value) const {
  Gathering gathering;
  for (const Arrival& arrival : arrivals_) gathering.add(value(arrival));
  return gathering.spread();
}

}  // namespace prehend::tools
