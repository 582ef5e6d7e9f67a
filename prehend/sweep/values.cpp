#include "prehend/sweep/values.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/text/input_error.h"

namespace prehend::sweep {
namespace {

using text::InputError;

constexpr int kDigits = 15;  // of a decimal: sums of two stay far below 2^63

std::int64_t power_of_ten(int exponent) {
  std::int64_t power = 1;
  for (int i = 0; i < exponent; ++i) power *= 10;
  return power;
}

// G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

// 0 <= u < 1, of 53 bits.
double unit(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

std::string decimal_text(std::int64_t digits, int places) {
  if (places == 0) return std::to_string(digits);
  std::string text = std::to_string(std::abs(digits));
  if (text.size() <= static_cast<std::size_t>(places)) {
    text.insert(0, static_cast<std::size_t>(places) + 1 - text.size(), '0');
  }
  text.insert(text.size() - static_cast<std::size_t>(places), ".");
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return (digits < 0 && text != "0" ? "-" : "") + text;
}

Decimal with_places(const Decimal& number, int places) {
  const int more = places - number.places;
  if (std::abs(number.digits) >= power_of_ten(kDigits - more)) {
    throw InputError(fmt::format("{} cannot be told exactly beside numbers of {} decimals",
                                 decimal_text(number.digits, number.places), places),
                     "Write fewer digits, or use count in place of step");
  }
  return {number.digits * power_of_ten(more), places};
}

}  // namespace

std::string number_text(double value) { return fmt::format("{}", value); }

std::uint64_t stable_hash(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

Decimal Decimal::parse(const std::string& text) {
  static const std::regex kNumber(R"(([+-]?)(\d+)(?:\.(\d+))?(?:[eE]([+-]?\d{1,2}))?)");
  std::smatch match;
  const auto refuse = [&] {
    throw InputError("'" + text + "' is no decimal number of at most 15 digits",
                     "Write one such as 0.25 or 3");
  };
  if (!std::regex_match(text, match, kNumber)) refuse();
  std::string digits = match[2].str() + match[3].str();
  int places = static_cast<int>(match[3].length());
  if (match[4].matched) places -= std::stoi(match[4]);
  digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size() - 1));
  for (; places < 0 && digits.size() <= kDigits; ++places) digits += '0';
  if (digits == std::string(digits.size(), '0')) digits = "0", places = std::max(places, 0);
  if (places < 0 || places > kDigits || digits.size() > kDigits) refuse();
  const std::int64_t size = std::stoll(digits);
  return {match[1] == "-" ? -size : size, places};
}

double Decimal::value() const {
  return static_cast<double>(digits) / static_cast<double>(power_of_ten(places));
}

Values Values::list(std::vector<std::string> words) {
  if (words.empty()) throw InputError("There are no values", "Write at least one");
  std::set<std::string> seen;
  for (const std::string& word : words) {
    if (!seen.insert(word).second) {
      throw InputError("The value '" + word + "' is there twice", "Write it once");
    }
  }
  Values values;
  values.size_ = static_cast<std::int64_t>(words.size());
  values.words_ = std::move(words);
  return values;
}

Values Values::steps(const std::string& from, const std::string& to, const std::string& step) {
  Decimal first = Decimal::parse(from), last = Decimal::parse(to), by = Decimal::parse(step);
  const int places = std::max({first.places, last.places, by.places});
  first = with_places(first, places);
  last = with_places(last, places);
  by = with_places(by, places);
  const std::int64_t way = last.digits - first.digits;
  if (by.digits == 0 || (way != 0 && (way > 0) != (by.digits > 0))) {
    throw InputError(fmt::format("Steps of {} never lead from {} to {}", step, from, to),
                     way < 0 ? "Write a step below 0" : "Write a step above 0");
  }
  Values values;
  values.from_ = first;
  values.step_ = by;
  values.size_ = way / by.digits + 1;
  return values;
}

Values Values::spread(double from, double to, std::int64_t count, bool logarithmic) {
  if (count < 2 || from == to) {
    throw InputError("A count spreads at least 2 values between ends that differ",
                     "Write a list for a single value");
  }
  if (logarithmic && (from <= 0 || to <= 0)) {
    throw InputError("Equal ratios need ends above 0", "Correct from and to, or leave out spacing");
  }
  Values values;
  values.spread_ = true;
  values.logarithmic_ = logarithmic;
  values.first_ = from;
  values.last_ = to;
  values.size_ = count;
  return values;
}

std::string Values::at(std::int64_t index) const {
  if (index < 0 || index >= size_) throw std::out_of_range("Values::at");
  if (!words_.empty()) return words_[static_cast<std::size_t>(index)];
  if (!spread_) return decimal_text(from_.digits + index * step_.digits, from_.places);
  // The ends are as they were written, whatever rounding would make of them.
  if (index == 0) return number_text(first_);
  if (index == size_ - 1) return number_text(last_);
  const double part = static_cast<double>(index) / static_cast<double>(size_ - 1);
  return number_text(logarithmic_ ? first_ * std::pow(last_ / first_, part)
                                  : first_ + (last_ - first_) * part);
}

std::string Distribution::draw(std::uint64_t seed, const std::string& name,
                               std::uint64_t index) const {
  const std::uint64_t start = mixed(mixed(mixed(seed) ^ stable_hash(name)) ^ index);
  const double u = unit(start);
  switch (kind) {
    case Kind::kUniform:
      return number_text(low + (high - low) * u);
    case Kind::kLogUniform:
      return number_text(low * std::pow(high / low, u));
    case Kind::kNormal: {
      // Box and Muller; 1 - u is above 0.
      const double angle = 2 * std::numbers::pi * unit(mixed(start));
      return number_text(low + high * std::sqrt(-2 * std::log(1 - u)) * std::cos(angle));
    }
    case Kind::kInteger:
      return fmt::format("{:.0f}", low + std::floor(u * (high - low + 1)));
    case Kind::kChoice:
      return choices[static_cast<std::size_t>(u * static_cast<double>(choices.size()))];
  }
  throw std::logic_error("Distribution: no such kind");
}

}  // namespace prehend::sweep
