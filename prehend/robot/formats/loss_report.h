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
    /// kExtended: prehend's extension keeps it, which other programs do not read.
    enum class Fate { kApproximated, kDropped, kExtended } fate = Fate::kDropped;
    std::string place;  // "hand.urdf:12", or "joint 'a'" of what is written
    std::string what;   // "limit/@effort"
    std::string why;    // how it was approximated, of kExtended for others; or why it was dropped
  };

  void keep(const std::string& what, std::size_t count = 1) { kept_[what] += count; }
  void approximate(const std::string& place, const std::string& what, const std::string& how) {
    entries_.push_back({Entry::Fate::kApproximated, place, what, how});
  }
  void drop(const std::string& place, const std::string& what, const std::string& why) {
    entries_.push_back({Entry::Fate::kDropped, place, what, why});
  }

  /// @param how other programs read it; empty: not at all
  void extend(const std::string& place, const std::string& what, const std::string& how) {
    entries_.push_back({Entry::Fate::kExtended, place, what, how});
  }

  const std::vector<Entry>& entries() const { return entries_; }
  /// How often each element and attribute was read and kept, by its path.
  const std::map<std::string, std::size_t>& kept() const { return kept_; }
  std::size_t count(Entry::Fate fate) const;
  /// Whether prehend reads all of it again: what is extended is not lost.
  bool lossless() const { return count(Entry::Fate::kExtended) == entries_.size(); }
  /// A line for each entry, equal ones counted, then what is extended, then the sums.
  std::string text() const;

 private:
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t> kept_;
};

}  // namespace prehend::robot::formats
