#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace prehend::robot::formats {

/// What became of all that a file says, and of all that a description says when it is written:
/// nothing is lost in silence.
class LossReport {
 public:
  struct Entry {
    enum class Fate { kApproximated, kDropped } fate = Fate::kDropped;
    std::string place;  // "hand.urdf:12", or "joint 'a'" of what is written
    std::string what;   // "limit/@effort"
    std::string why;    // how it was approximated, or why it was dropped
  };

  void keep(const std::string& what, std::size_t count = 1) { kept_[what] += count; }
  void approximate(const std::string& place, const std::string& what, const std::string& how) {
    entries_.push_back({Entry::Fate::kApproximated, place, what, how});
  }
  void drop(const std::string& place, const std::string& what, const std::string& why) {
    entries_.push_back({Entry::Fate::kDropped, place, what, why});
  }

  const std::vector<Entry>& entries() const { return entries_; }
  /// How often each element and attribute was read and kept, by its path.
  const std::map<std::string, std::size_t>& kept() const { return kept_; }
  std::size_t count(Entry::Fate fate) const;
  bool lossless() const { return entries_.empty(); }
  /// A line for each entry, equal ones counted, then the sums.
  std::string text() const;

 private:
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t> kept_;
};

}  // namespace prehend::robot::formats
