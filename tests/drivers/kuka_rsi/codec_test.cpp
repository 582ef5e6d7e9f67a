// Telegrams as KUKA's manuals and public clients print them, and such as nobody should believe.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "drivers/kuka_rsi/codec/telegram.h"
#include "drivers/kuka_rsi/codec/xml_reader.h"

namespace prehend::drivers::kuka_rsi {
namespace {

using ::testing::HasSubstr;

constexpr const char* kShortest =
    R"(<Rob Type="KUKA"><RIst X="560.0000" Y="0.0000" Z="790.0000" A="0.0000" B="90.0000" C="0.0000"/>)"
    R"(<AIPos A1="0.0000" A2="-90.0000" A3="90.0000" A4="0.0000" A5="0.0000" A6="0.0000"/>)"
    R"(<Delay D="0"/><IPOC>4208163634</IPOC></Rob>)";

RobotTelegram read(const std::string& text, const TelegramNames& names = {}) {
  RobotTelegram telegram;
  const char* why = "";
  EXPECT_EQ(read_robot_telegram(text, names, telegram, why), TelegramResult::kGood) << why;
  return telegram;
}

std::string refusal(const std::string& text) {
  RobotTelegram telegram;
  const char* why = "";
  if (read_robot_telegram(text, {}, telegram, why) != TelegramResult::kWrong) return "taken";
  return why;
}

TEST(RobotTelegrams, TheShortestUsefulOneIsRead) {
  const RobotTelegram telegram = read(kShortest);
  EXPECT_EQ(*telegram.actual_axes, (Axes{0, -90, 90, 0, 0, 0}));
  EXPECT_EQ(*telegram.actual_pose, (Axes{560, 0, 790, 0, 90, 0}));
  EXPECT_FALSE(telegram.commanded_axes);
  EXPECT_EQ(telegram.delay, 0u);
  EXPECT_EQ(telegram.ipoc.value, 4208163634u);  // above 2^31
  EXPECT_EQ(telegram.ipoc.text(), "4208163634");
}

TEST(RobotTelegrams, AnyLayoutSpellingAndOrderIsRead) {
  const RobotTelegram telegram = read(
      "\r\n<Rob TYPE='KUKA'>\r\n  <Delay D = \"7\" />\r\n\t<Tech C11=\"0.000000\" C12=\"1\"/>\r\n"
      "<o4></o4><DiL>0</DiL><MACur A1=\"1.5\"/>\r\n<AIPos A1=\"1e1\" A2=\"-90.5\" A3=\"90\" "
      "A4=\"0\" A5=\"0\" A6=\"-0.25\"></AIPos>\r\n<ASPos A1=\"10\" A2=\"-90.5\" A3=\"90\" A4=\"0\" "
      "A5=\"0\" A6=\"-0.25\"/>\r\n<IPOC> 18446744073709551615 </IPOC>\r\n</Rob>\r\n");
  EXPECT_EQ(*telegram.actual_axes, (Axes{10, -90.5, 90, 0, 0, -0.25}));
  EXPECT_EQ(*telegram.commanded_axes, *telegram.actual_axes);
  EXPECT_EQ(telegram.delay, 7u);
  EXPECT_EQ(telegram.ipoc.value, std::numeric_limits<std::uint64_t>::max());
}

TEST(RobotTelegrams, EmptyAttributesAreAsIfTheyWereNotThere) {
  const RobotTelegram telegram =
      read(R"(<Rob><AIPos A1="" A2="" A3="" A4="" A5="" A6=""/><Delay D=""/><IPOC>1</IPOC></Rob>)");
  EXPECT_FALSE(telegram.actual_axes);
  EXPECT_FALSE(telegram.delay);
}

TEST(RobotTelegrams, TheFirstOneOfOldControllersIsShort) {
  RobotTelegram telegram;
  const char* why = "";
  EXPECT_EQ(read_robot_telegram("<Rob Type=\"KUKA\"></Rob>", {}, telegram, why),
            TelegramResult::kShort);
}

TEST(RobotTelegrams, HostileAndDamagedOnesAreRefusedInWords) {
  const std::string axes = R"(<AIPos A1="0" A2="0" A3="0" A4="0" A5="0" A6="0"/>)";
  const struct {
    std::string text;
    const char* why;
  } bad[] = {
      {"", "empty"},
      {"   \r\n", "empty"},
      {"<?xml version=\"1.0\"?><Rob><IPOC>1</IPOC></Rob>", "declaration"},
      {"<!DOCTYPE a [<!ENTITY b \"c\">]><Rob><IPOC>1</IPOC></Rob>", "document type"},
      {"<Rob><!-- --><IPOC>1</IPOC></Rob>", "comment"},
      {"<Rob><![CDATA[1]]><IPOC>1</IPOC></Rob>", "declaration"},
      {"<Rob><IPOC>&lol;</IPOC></Rob>", "entity"},
      {"<Rob><IPOC>&#49;</IPOC></Rob>", "reference"},
      {"<Rob a=\"&quot;\"><IPOC>1</IPOC></Rob>", "reference"},
      {"<Rob><a><b><c><d/></c></b></a></Rob>", "nested too deeply"},
      {"<Rob><IPOC>1</IPOC></Rob><Rob/>", "two root"},
      {"<Rob><IPOC>1</IPOC></Rob>x", "outside"},
      {"x<Rob/>", "outside"},
      {"<Rob><IPOC>1</IPOC></Sen>", "closes another"},
      {"</Rob>", "closes another"},
      {"<Rob><IPOC>1</IPOC>", "cut off"},
      {"<Rob", "separated"},
      {"<Rob a=\"1", "quotes"},
      {"<Rob a=1/>", "quotes"},
      {"<Rob a/>", "no value"},
      {"<Rob a=\"1\" a=\"2\"/>", "twice"},
      {"<Rob a=\"1\"b=\"2\"/>", "separated"},
      {"<1/>", "name"},
      {"<Rob>" + std::string(1, '\0') + "</Rob>", "control"},
      {"<" + std::string(33, 'R') + "/>", "name"},
      {"<Sen><IPOC>1</IPOC></Sen>", "root"},
      {"<Rob><IPOC>1</IPOC><IPOC>2</IPOC></Rob>", "twice"},
      {"<Rob><IPOC>-1</IPOC></Rob>", "time stamp"},
      {"<Rob><IPOC>18446744073709551616</IPOC></Rob>", "time stamp"},
      {"<Rob><IPOC>1 2</IPOC></Rob>", "time stamp"},
      {"<Rob>" + axes + axes + "<IPOC>1</IPOC></Rob>", "twice"},
      {R"(<Rob><AIPos A1="nan" A2="0" A3="0" A4="0" A5="0" A6="0"/><IPOC>1</IPOC></Rob>)", "none"},
      {R"(<Rob><AIPos A1="inf" A2="0" A3="0" A4="0" A5="0" A6="0"/><IPOC>1</IPOC></Rob>)", "none"},
      {R"(<Rob><AIPos A1="1e7" A2="0" A3="0" A4="0" A5="0" A6="0"/><IPOC>1</IPOC></Rob>)", "none"},
      {R"(<Rob><AIPos A1="1,5" A2="0" A3="0" A4="0" A5="0" A6="0"/><IPOC>1</IPOC></Rob>)", "none"},
      {R"(<Rob><AIPos A1="0" A2="0" A3="0" A4="0" A5="0"/><IPOC>1</IPOC></Rob>)", "missing"},
      {R"(<Rob><Delay D="x"/><IPOC>1</IPOC></Rob>)", "Delay"},
      {std::string(5000, ' ') + "<Rob/>", "longer than"},
  };
  for (const auto& one : bad) EXPECT_THAT(refusal(one.text), HasSubstr(one.why)) << one.text;
  std::string many = "<Rob";
  for (int i = 0; i < 17; ++i) many += " a" + std::to_string(i) + "=\"\"";
  EXPECT_THAT(refusal(many + "/>"), HasSubstr("too many attributes"));
}

TEST(RobotTelegrams, EveryBeginningOfOneIsRefused) {
  const std::string whole = kShortest;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(refusal(whole.substr(0, size)), "taken") << size;
  }
}

TEST(Answers, AreWhatTheManualPrints) {
  TelegramNames names;
  names.decimals = 4;
  std::array<char, 512> out;
  const std::size_t size = write_sensor_telegram(out, names, Axes{}, *Ipoc::parse("4208163634"));
  EXPECT_EQ(std::string(out.data(), size),
            R"(<Sen Type="ImFree"><EStr></EStr><AKorr A1="0.0000" A2="0.0000" A3="0.0000" )"
            R"(A4="0.0000" A5="0.0000" A6="0.0000"/><IPOC>4208163634</IPOC></Sen>)");
}

TEST(Answers, AreWhatKexpsControllerTakes) {
  TelegramNames names;
  names.correction = "AK";
  names.message = "";
  std::array<char, 512> out;
  const std::size_t size = write_sensor_telegram(
      out, names, Axes{0.1, -0.0000004, 90, -12.3456789, 1e-6, 359.999999}, Ipoc::of(1));
  EXPECT_EQ(std::string(out.data(), size),
            R"(<Sen Type="ImFree"><AK A1="0.100000" A2="0.000000" A3="90.000000" A4="-12.345679" )"
            R"(A5="0.000001" A6="359.999999"/><IPOC>1</IPOC></Sen>)");
}

TEST(Answers, DoNotGoOutDamaged) {
  std::array<char, 512> out;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(write_sensor_telegram(out, {}, Axes{0, 0, nan}, Ipoc::of(1)), 0u);
  EXPECT_EQ(write_sensor_telegram(out, {}, Axes{1e9}, Ipoc::of(1)), 0u);
  for (std::size_t room = 0; room < 144; ++room) {
    EXPECT_EQ(write_sensor_telegram(std::span(out).first(room), {}, Axes{}, Ipoc::of(1)), 0u);
  }
  const std::size_t size =
      write_sensor_telegram(out, {}, Axes{}, Ipoc::of(1), "Error: <force> & \"more\"\n");
  SensorTelegram answer;
  const char* why = "";
  EXPECT_EQ(read_sensor_telegram({out.data(), size}, {}, answer, why), TelegramResult::kGood);
  EXPECT_EQ(answer.message, "Error:  force    \"more\"");
}

TEST(Answers, SayWhatWasWritten) {
  std::array<char, 512> out;
  const Axes correction{1, -2, 3.5, 0, 0.000001, -170};
  const std::size_t size = write_sensor_telegram(out, {}, correction, *Ipoc::parse("007"));
  SensorTelegram answer;
  const char* why = "";
  ASSERT_EQ(read_sensor_telegram({out.data(), size}, {}, answer, why), TelegramResult::kGood);
  EXPECT_EQ(answer.type, "ImFree");
  EXPECT_EQ(answer.ipoc.text(), "007");  // the same text, not only the same number
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_NEAR((*answer.correction)[i], correction[i], 5e-7);
}

TEST(RobotTelegrams, OfTheEmulatorAreReadInEveryLayout) {
  RobotTelegram telegram;
  telegram.actual_axes = Axes{1, 2, 3, 4, 5, 6};
  telegram.commanded_axes = Axes{-1, -2, -3, -4, -5, -6};
  telegram.actual_pose = Axes{1620.0008, 0, 1, 2, 3, 4};
  telegram.delay = 3;
  telegram.ipoc = Ipoc::of(1ull << 40);
  for (const bool lines : {false, true}) {
    for (const int decimals : {1, 4, 6}) {
      std::array<char, 1400> out;
      const std::size_t size = write_robot_telegram(
          out, {}, telegram, {.decimals = decimals, .has_lines = lines, .type_in_capitals = lines});
      const RobotTelegram again = read(std::string(out.data(), size));
      EXPECT_EQ(again.actual_axes, telegram.actual_axes);
      EXPECT_EQ(again.commanded_axes, telegram.commanded_axes);
      EXPECT_NEAR((*again.actual_pose)[0], 1620.0008, 0.6 * std::pow(10, -decimals));
      EXPECT_EQ(again.delay, 3u);
      EXPECT_EQ(again.ipoc.value, 1ull << 40);
    }
  }
}

}  // namespace
}  // namespace prehend::drivers::kuka_rsi
