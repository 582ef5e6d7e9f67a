// What a KUKA's controller, or who says to be one, sends: `kind byte | text`, of odd kind a
// telegram, of even kind an answer to one.

#include <array>
#include <cmath>
#include <string_view>

#include "drivers/kuka_rsi/codec/telegram.h"
#include "drivers/kuka_rsi/codec/xml_reader.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend::drivers::kuka_rsi;
using prehend::fuzz::FuzzInput;

void fuzz_reader(std::string_view text) {
  XmlReader reader(text);
  std::size_t events = 0;
  auto event = reader.next();
  for (; event != XmlReader::Event::kDone && event != XmlReader::Event::kWrong;
       event = reader.next()) {
    FUZZ_CHECK(++events <= text.size());
    FUZZ_CHECK(reader.depth() <= XmlReader::kMostDepth);
    FUZZ_CHECK(reader.attributes().size() <= XmlReader::kMostAttributes);
    FUZZ_CHECK(event == XmlReader::Event::kText || !reader.name().empty());
    FUZZ_CHECK(reader.name().size() <= XmlReader::kLongestName);
  }
  const bool is_wrong = event == XmlReader::Event::kWrong;
  FUZZ_CHECK(is_wrong == (*reader.problem() != '\0'));
  FUZZ_CHECK(is_wrong || text.size() <= XmlReader::kLongestText);
  FUZZ_CHECK(is_wrong || text.find('&') == std::string_view::npos);
  FUZZ_CHECK(is_wrong || text.find("<!") == std::string_view::npos);
}

void check_axes(const std::optional<Axes>& axes) {
  if (!axes) return;
  for (const double value : *axes) FUZZ_CHECK(std::abs(value) <= 1e6);
}

void fuzz_robot(std::string_view text) {
  RobotTelegram telegram;
  const char* why = nullptr;
  const TelegramResult result = read_robot_telegram(text, {}, telegram, why);
  FUZZ_CHECK((result == TelegramResult::kWrong) == (*why != '\0'));
  if (result != TelegramResult::kGood) return;
  check_axes(telegram.actual_axes);
  check_axes(telegram.commanded_axes);
  check_axes(telegram.actual_pose);
  FUZZ_CHECK(Ipoc::parse(telegram.ipoc.text())->value == telegram.ipoc.value);
  // What was believed is what is written again.
  std::array<char, 2048> out;
  const std::size_t size = write_robot_telegram(out, {}, telegram, {.decimals = 9});
  FUZZ_CHECK(size > 0);
  RobotTelegram again;
  FUZZ_CHECK(read_robot_telegram({out.data(), size}, {}, again, why) == TelegramResult::kGood);
  FUZZ_CHECK(again.ipoc.value == telegram.ipoc.value && again.delay == telegram.delay);
  FUZZ_CHECK(again.actual_axes.has_value() == telegram.actual_axes.has_value());
  for (std::size_t i = 0; telegram.actual_axes && i < kAxes; ++i) {
    FUZZ_CHECK(std::abs((*again.actual_axes)[i] - (*telegram.actual_axes)[i]) < 1e-6);
  }
}

void fuzz_answer(std::string_view text) {
  SensorTelegram answer;
  const char* why = nullptr;
  if (read_sensor_telegram(text, {}, answer, why) != TelegramResult::kGood) return;
  check_axes(answer.correction);
  if (!answer.correction) return;
  std::array<char, 2048> out;
  FUZZ_CHECK(write_sensor_telegram(out, {}, *answer.correction, answer.ipoc) > 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzInput input(data, size);
  const std::uint8_t kind = input.byte();
  const std::string_view text = input.rest();
  fuzz_reader(text);
  kind % 2 ? fuzz_robot(text) : fuzz_answer(text);
  return 0;
}
