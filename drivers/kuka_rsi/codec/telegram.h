#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace prehend::drivers::kuka_rsi {

inline constexpr std::size_t kAxes = 6;
/// A1 to A6, or X Y Z A B C. Degrees and millimetres on the wire, rad and m everywhere else.
using Axes = std::array<double, kAxes>;

/// The time stamp of a telegram. The answer has to bear the same text, and values above 2^32 occur
/// (manual of Ethernet RSI XML 1.2), so both are kept.
struct Ipoc {
  std::uint64_t value = 0;
  std::array<char, 20> digits{'0'};
  std::uint8_t size = 1;

  std::string_view text() const { return {digits.data(), size}; }
  static std::optional<Ipoc> parse(std::string_view text);
  static Ipoc of(std::uint64_t value);
};

/// What the controller's configuration file (RSI_EthernetConfig) calls things. The names of KUKA's
/// own keywords (DEF_AIPos and so on) are fixed, that of the correction is free.
struct TelegramNames {
  std::string robot = "Rob", sensor = "Sen";  // root elements
  std::string type = "ImFree";                // SENTYPE: compared in each answer
  std::string actual_axes = "AIPos", commanded_axes = "ASPos", actual_pose = "RIst";
  std::string delay = "Delay";       // its attribute is D
  std::string correction = "AKorr";  // AK in KEXP and KES
  std::string message = "EStr";      // "": the configuration has none
  int decimals = 6;                  // of the correction [deg], 1 to 9
};

/// The controller's telegram, as far as anybody here needs it.
struct RobotTelegram {
  std::optional<Axes> actual_axes;     // deg
  std::optional<Axes> commanded_axes;  // deg; without the corrections (measured, RSIPI)
  std::optional<Axes> actual_pose;     // mm, deg: of the active tool in the active base
  std::optional<std::uint64_t> delay;  // telegrams so far that were not answered in time
  Ipoc ipoc;
};

/// The answer to it.
struct SensorTelegram {
  std::string_view type, message;  // of the text that was read
  std::optional<Axes> correction;  // deg
  Ipoc ipoc;
};

enum class TelegramResult {
  kGood,
  kShort,  ///< right, but without a time stamp: the first one of RSI 2.x up to 2.3 (KEXP)
  kWrong,  ///< see `why`
};

/// Reads a telegram of the controller: elements in any order, others skipped, empty attributes as
/// if they were not there (printed in the manual). Refused: what XmlReader refuses, another root,
/// an element that is given twice, numbers that are none, are not finite or beyond 1e6, an axis of
/// six missing, no digits in IPOC or Delay. Allocates nothing. `why`: in words, "" where good.
TelegramResult read_robot_telegram(std::string_view text, const TelegramNames& names,
                                   RobotTelegram& telegram, const char*& why);

/// The same of an answer; its views are of `text`.
TelegramResult read_sensor_telegram(std::string_view text, const TelegramNames& names,
                                    SensorTelegram& telegram, const char*& why);

/// Writes an answer with the correction [deg] into `out` and returns its length; 0 where it does
/// not fit or a number is not finite. `message`: of EStr; characters that XML would have to escape
/// become spaces. Allocates nothing.
std::size_t write_sensor_telegram(std::span<char> out, const TelegramNames& names,
                                  const Axes& correction, const Ipoc& ipoc,
                                  std::string_view message = {});

struct RobotLayout {
  int decimals = 4;
  bool has_lines = false;         // CRLF between elements, as simulators send; else compact
  bool type_in_capitals = false;  // TYPE="KUKA" for Type="KUKA"
};

/// Writes a telegram of the controller, in the order of KEXP's configuration.
std::size_t write_robot_telegram(std::span<char> out, const TelegramNames& names,
                                 const RobotTelegram& telegram, const RobotLayout& layout);

}  // namespace prehend::drivers::kuka_rsi
