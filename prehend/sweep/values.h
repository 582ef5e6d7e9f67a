#pragma once

#include <cstdint>
#include <string>
#include <vector>

// What a parameter of a sweep takes, as the words that go on a command line. Words stay as they
// were written and numbers are the same on every machine, as cases are named by them.
namespace prehend::sweep {

/// A decimal number that is exact: digits * 10^-places.
struct Decimal {
  std::int64_t digits = 0;
  int places = 0;  // 0..15

  /// "-0.25", "3", "1e-3". @throws InputError when it is no such number of at most 15 digits.
  static Decimal parse(const std::string& text);
  double value() const;
};

/// The values of one parameter of a grid, in their order. Ranges take no memory.
class Values {
 public:
  /// Words. @throws InputError when there are none or one is there twice.
  static Values list(std::vector<std::string> words);
  /// from, from + step, ... as far as `to`, which belongs to them where the steps meet it. Exact:
  /// 0.1 to 0.3 by 0.1 is 0.1, 0.2, 0.3. @throws InputError when it would never arrive.
  static Values steps(const std::string& from, const std::string& to, const std::string& step);
  /// `count` numbers with equal differences, or equal ratios if `logarithmic`, both ends included.
  /// @throws InputError for count < 2, equal ends and, if logarithmic, ends that are not above 0.
  static Values spread(double from, double to, std::int64_t count, bool logarithmic);

  std::int64_t size() const { return size_; }
  /// @pre 0 <= index < size()
  std::string at(std::int64_t index) const;

 private:
  Values() = default;
  std::vector<std::string> words_;
  Decimal from_, step_;  // of the same places
  double first_ = 0, last_ = 0;
  bool spread_ = false, logarithmic_ = false;
  std::int64_t size_ = 0;
};

/// What is drawn for a parameter of a sample.
struct Distribution {
  enum class Kind { kUniform, kLogUniform, kNormal, kInteger, kChoice };
  Kind kind = Kind::kUniform;
  double low = 0, high = 1;          // kNormal: mean and standard deviation; kInteger: inclusive
  std::vector<std::string> choices;  // kChoice, each as likely

  /// Draw number `index` of the parameter `name`: depends on these and `seed` alone, so that more
  /// draws leave those that are there as they were.
  std::string draw(std::uint64_t seed, const std::string& name, std::uint64_t index) const;
};

/// The shortest text that reads as the same double: "0.1", "1e-07".
std::string number_text(double value);

/// FNV-1a, 64 bit: the same everywhere and always, for names and draws, not against adversaries.
std::uint64_t stable_hash(const std::string& text);

}  // namespace prehend::sweep
