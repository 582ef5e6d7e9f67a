#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>

namespace prehend::tools {

/// Mean, least, greatest value and standard deviation (of the population) of some samples.
struct Spread {
  std::size_t count = 0;
  double mean = 0, least = 0, greatest = 0, deviation = 0;
};

/// The last arrivals of messages.
class Arrivals {
 public:
  struct Arrival {
    double time = 0;   ///< of receipt, of a steady clock [s]
    double bytes = 0;  ///< encoded
    double delay = 0;  ///< receipt - stamp, by the node's clock [s]
  };

  /// `window`: how many are kept, > 1.
  explicit Arrivals(std::size_t window) : window_(window) {}
  void add(const Arrival& arrival);

  std::size_t size() const { return arrivals_.size(); }
  std::uint64_t total() const { return total_; }
  /// Messages and bytes a second between the first and the last arrival; 0 below two arrivals.
  double rate() const;
  double bytes_per_second() const;
  /// Of the times between arrivals [s].
  Spread intervals() const;
  Spread bytes() const;
  Spread delays() const;

 private:
  double span() const;
  Spread spread_of(const std::function<double(const Arrival&)>& value) const;

  const std::size_t window_;
  std::deque<Arrival> arrivals_;
  std::uint64_t total_ = 0;
};

}  // namespace prehend::tools
