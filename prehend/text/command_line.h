#pragma once

#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>

#include "prehend/text/input_error.h"
#include "prehend/text/quantities.h"

// What the command lines of all programs have in common, beside CLI11.
namespace prehend::text {

/// Accepts numbers from `least` to `most`. CLI11's own takes "nan" for one of any range.
template <class Number>
CLI::Validator in_range(Number least, Number most) {
  std::ostringstream bounds;
  bounds << least << " - " << most;
  const auto check = [least, most, range = bounds.str()](const std::string& word) {
    Number value{};
    const bool is_number = CLI::detail::lexical_cast(word, value);
    if (is_number && value >= least && value <= most) return std::string();
    return "'" + word + "' is no number in [" + range + "]";
  };
  return {check, std::string(CLI::detail::type_name<Number>()) + " in [" + bounds.str() + "]"};
}

/// Accepts finite numbers above 0, or from 0 on.
inline CLI::Validator above_zero(bool or_zero = false) {
  const auto check = [or_zero](const std::string& word) {
    double value = 0;
    const bool is_number = CLI::detail::lexical_cast(word, value) && std::isfinite(value);
    if (is_number && (or_zero ? value >= 0 : value > 0)) return std::string();
    return "'" + word + "' is no number " + (or_zero ? "from 0 on" : "above 0");
  };
  return {check, or_zero ? "NONNEGATIVE" : "POSITIVE"};
}

/// Turns quantities with their unit ("150ms", by `parse`) into bare numbers in SI's, which stay.
inline CLI::Validator of_quantity(double (*parse)(const std::string&), const char* name) {
  const auto in_si = [parse](std::string& word) {
    double bare = 0;
    if (CLI::detail::lexical_cast(word, bare)) return std::string();
    try {
      std::ostringstream number;
      number << std::setprecision(17) << parse(word);
      word = number.str();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  return {in_si, name};
}
inline CLI::Validator in_seconds() { return of_quantity(parse_seconds, "TIME"); }
inline CLI::Validator in_metres() { return of_quantity(parse_metres, "LENGTH"); }

/// Takes the words of a command line. Returns main()'s exit code where there is nothing more to do:
/// 0 for --help, 2 for wrong use, which is said.
inline std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return std::nullopt;
}

}  // namespace prehend::text
