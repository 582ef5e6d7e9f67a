// The driver against the emulated controller, in simulated time and over real lines.

#include <gtest/gtest.h>
#include <malloc.h>

#include <filesystem>
#include <limits>
#include <random>

#include "drivers/dsa/driver/device.h"
#include "drivers/dsa/driver/lost_frames.h"
#include "drivers/dsa/emulator/controller.h"
#include "drivers/wire/faults/faulty_line.h"
#include "drivers/wire/faults/faulty_stream.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/served_device.h"
#include "drivers/wire/stream/tcp_server.h"
#include "tests/drivers/eventually.h"

namespace prehend::drivers::dsa {
namespace {

using namespace std::chrono_literals;
using Block = std::vector<std::uint8_t>;

/// Both ends in simulated time.
class VirtualPads {
 public:
  explicit VirtualPads(const DriverOptions& options = {}, const ControllerOptions& of_device = {})
      : controller(of_device,
                   [this](Bytes bytes) { line.push(Block(bytes.begin(), bytes.end()), now); }),
        driver(
            options,
            [this](Bytes bytes) {
              controller.receive(bytes, now);
              return std::string();
            },
            [this](const Frame& frame) { frames.push_back(frame); },
            [this](bool is_problem, const std::string& words) {
              if (is_problem) problems.push_back(words);
            }) {}
  void run(double seconds) {
    const Time end = now + to_time(seconds);
    while (now < end) {
      now += 1ms;
      controller.update(now);
      while (const auto block = line.pop(now)) driver.receive(*block, now);
      driver.update(now);
    }
  }
  bool has_problem(const std::string& part) const {
    return std::ranges::any_of(
        problems, [&](const std::string& words) { return words.find(part) != std::string::npos; });
  }

  Time now = 50s;
  FaultyLine<Block> line{[](Block& block, std::mt19937_64& random) {
    block[random() % block.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
  }};
  std::vector<Frame> frames;
  std::vector<std::string> problems;
  Controller controller;
  Driver driver;
};

TEST(DsaDriver, StreamsEveryFrameWithWhatThePadsFeel) {
  VirtualPads pads;
  std::vector<std::uint16_t> texels(168);
  for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = static_cast<std::uint16_t>(i * 7);
  pads.controller.set_texels(texels);
  pads.driver.connected(pads.now);
  pads.run(2);
  ASSERT_EQ(pads.driver.state(), DriverState::kStreaming);
  ASSERT_EQ(pads.driver.matrices().size(), 2u);
  EXPECT_EQ(pads.driver.matrices()[1].cells_y, 14);
  EXPECT_EQ(pads.driver.offset(1), 84u);
  EXPECT_EQ(pads.driver.controller()->software, 300);
  const auto before = pads.controller.frames();
  pads.frames.clear();
  pads.run(10);
  EXPECT_NEAR(static_cast<double>(pads.frames.size()), 300, 2);
  EXPECT_NEAR(static_cast<double>(pads.controller.frames() - before),
              static_cast<double>(pads.frames.size()), 1);
  for (const Frame& frame : pads.frames) ASSERT_EQ(frame.texels, texels);
  EXPECT_NEAR(pads.driver.statistics().frame_rate, 30, 1);
  EXPECT_EQ(pads.driver.statistics().bad_frames, 0u);
  EXPECT_TRUE(pads.problems.empty());
}

TEST(DsaDriver, TwoMinutesOfSixPadsAccountForEveryFrame) {
  ControllerOptions six;
  for (int i = 0; i < 4; ++i) six.matrices.push_back({6, 13, 3.4});
  VirtualPads pads({}, six);
  std::mt19937 random(1);
  pads.driver.connected(pads.now);
  pads.run(0.6);
  for (int i = 0; i < 120; ++i) {
    std::vector<std::uint16_t> texels(pads.controller.texels());
    for (std::size_t k = 0; k < 40; ++k) texels[random() % texels.size()] = random() % 4096;
    pads.controller.set_texels(texels);
    pads.run(1);
  }
  const Statistics statistics = pads.driver.statistics();
  EXPECT_EQ(statistics.frames, pads.frames.size());
  EXPECT_LE(pads.controller.frames() - statistics.frames, 1u);  // one may be on the line
  EXPECT_NEAR(static_cast<double>(statistics.frames), 30 * 120, 40);
  EXPECT_EQ(statistics.discarded + statistics.bad_frames + statistics.bad_checksums, 0u);
}

TEST(DsaDriver, FramesThatNeverCameAreCountedByTheirTimeStamps) {
  VirtualPads pads;
  pads.driver.connected(pads.now);
  pads.run(2);
  ASSERT_EQ(pads.driver.statistics().lost_frames, 0u);
  pads.line.set_faults({.dropped = 0.15});
  const auto sent = pads.controller.frames();
  const auto came = pads.driver.statistics().frames;
  pads.run(60);
  const auto lost = (pads.controller.frames() - sent) - (pads.driver.statistics().frames - came);
  ASSERT_GT(lost, 200u);
  // All but those beside another loss.
  const auto counted = pads.driver.statistics().lost_frames;
  EXPECT_LE(counted, lost);
  EXPECT_GT(static_cast<double>(counted), 0.6 * static_cast<double>(lost));
  pads.line.set_faults({.corrupted = 0.15});
  pads.run(60);
  pads.line.set_faults({});
  pads.run(1);
  const Statistics after = pads.driver.statistics();
  EXPECT_GT(after.bad_frames + after.bad_checksums, 100u);
  // One that is damaged came; a damaged head or length makes a frame that is not seen at all.
  EXPECT_LT(after.lost_frames - counted, 60u);
  pads.run(10);
  EXPECT_LE(pads.driver.statistics().lost_frames - after.lost_frames, 1u);
}

TEST(DsaDriver, FramesThatTakeLongerAreNotLost) {
  ControllerOptions six;
  for (int i = 0; i < 4; ++i) six.matrices.push_back({6, 13, 3.4});
  VirtualPads pads({}, six);
  pads.driver.connected(pads.now);
  pads.run(3);
  // Nothing to be run-length coded: the frame takes three times as long on the line.
  std::vector<std::uint16_t> texels(pads.controller.texels());
  for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = static_cast<std::uint16_t>(i * 8);
  pads.controller.set_texels(texels);
  pads.run(5);
  EXPECT_LT(pads.driver.statistics().frame_rate, 15);
  pads.controller.set_texels(std::vector<std::uint16_t>(texels.size(), 0));
  pads.run(5);
  EXPECT_EQ(pads.driver.statistics().lost_frames, 0u);
}

TEST(DsaLostFrames, AClockThatWrapsAndAStreamThatBeginsAnewAreNone) {
  LostFrames lost;
  std::uint32_t time = 0xffffffff - 150;
  const auto come = [&](int frames) {
    for (int i = 0; i < frames; ++i) lost.take(time += 33, 0);
  };
  come(20);
  EXPECT_EQ(lost.count(), 0u);
  time += 2 * 33;
  come(2);
  EXPECT_EQ(lost.count(), 2u);
  lost.restart();
  time += 5000;
  come(10);
  EXPECT_EQ(lost.count(), 2u);
  for (int i = 0; i < 10; ++i) lost.take(time, 0);  // a clock that stands
  EXPECT_EQ(lost.count(), 2u);
}

TEST(DsaDriver, RawFramesAreBoundByTheLine) {
  ControllerOptions six;
  for (int i = 0; i < 4; ++i) six.matrices.push_back({6, 13, 3.4});
  DriverOptions raw;
  raw.run_length = false;
  VirtualPads pads(raw, six);
  pads.driver.connected(pads.now);
  pads.run(6);
  EXPECT_NEAR(pads.driver.statistics().frame_rate, 11.7, 0.5);  // 988 bytes at 115200 baud
  EXPECT_EQ(pads.frames.back().texels.size(), 480u);
}

TEST(DsaDriver, WaitsForAControllerThatStartsUp) {
  ControllerOptions slow;
  slow.start_up = 8;
  VirtualPads pads({}, slow);
  pads.controller.reboot(pads.now);
  pads.driver.connected(pads.now);
  pads.run(7.9);
  EXPECT_TRUE(pads.frames.empty());
  EXPECT_TRUE(pads.problems.empty());  // nothing is wrong yet
  pads.run(2.5);
  EXPECT_EQ(pads.driver.state(), DriverState::kStreaming);
  EXPECT_EQ(pads.driver.statistics().discarded, 12u);  // three times ESC [5n
}

TEST(DsaDriver, SaysWhenNothingAnswersAndGoesOnTrying) {
  VirtualPads pads;
  pads.controller.set_silent(true);
  pads.driver.connected(pads.now);
  pads.run(20);
  EXPECT_TRUE(pads.has_problem("the controller does not answer"));
  pads.controller.set_silent(false);
  pads.run(5);
  EXPECT_EQ(pads.driver.state(), DriverState::kStreaming);
}

TEST(DsaDriver, StreamThatStopsIsStaleAndBeginsAnew) {
  VirtualPads pads;
  pads.driver.connected(pads.now);
  pads.run(2);
  pads.controller.reboot(pads.now);  // it forgets to stream
  pads.run(0.6);
  EXPECT_TRUE(pads.has_problem("no tactile frame for"));
  pads.run(3);
  EXPECT_EQ(pads.driver.state(), DriverState::kStreaming);
  EXPECT_EQ(pads.driver.statistics().restarts, 2u);
}

TEST(DsaDriver, StreamLeftOnByAnEarlierClientIsStoppedFirst) {
  VirtualPads pads;
  const Acquisition on{Acquisition::kAcquire, 30};  // raw, of one who died
  pads.controller.receive(encode_packet(3, encode(on)), pads.now);
  pads.run(1);
  pads.driver.connected(pads.now);
  pads.run(3);
  EXPECT_EQ(pads.driver.state(), DriverState::kStreaming);
  EXPECT_EQ(pads.driver.statistics().bad_frames, 0u);
}

TEST(DsaDriver, SensitivityAndThresholdAreSet) {
  DriverOptions options;
  options.sensitivity = 0.75;
  options.threshold = 200;
  VirtualPads pads(options);
  pads.driver.connected(pads.now);
  std::vector<std::uint16_t> texels(168, 199);
  texels[5] = 200;
  pads.controller.set_texels(texels);
  pads.run(2);
  EXPECT_EQ(pads.frames.back().texels[5], 200);
  EXPECT_EQ(pads.frames.back().texels[6], 0);
  ControllerOptions old;
  old.firmware = 260;
  VirtualPads without(options, old);
  without.driver.connected(without.now);
  without.run(3);
  EXPECT_EQ(without.driver.state(), DriverState::kStreaming);
  EXPECT_TRUE(without.has_problem("firmware older than 268 has none"));
}

TEST(DsaDriver, DeadTexelsAreZeroAndTheOthersLive) {
  VirtualPads pads;
  pads.controller.set_texels(std::vector<std::uint16_t>(168, 100));
  pads.controller.kill_texel(17);
  pads.driver.connected(pads.now);
  pads.run(2);
  EXPECT_EQ(pads.frames.back().texels[17], 0);
  EXPECT_EQ(pads.frames.back().texels[18], 100);
}

class DsaBadLine : public ::testing::TestWithParam<LineFaults> {};

TEST_P(DsaBadLine, NoWrongFrameIsHandedOn) {
  VirtualPads pads;
  std::vector<std::uint16_t> texels(168);
  for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = static_cast<std::uint16_t>(i * 11);
  pads.controller.set_texels(texels);
  pads.driver.connected(pads.now);
  pads.run(1);
  pads.line.set_faults(GetParam());
  pads.run(60);
  for (const Frame& frame : pads.frames) ASSERT_EQ(frame.texels, texels);
  EXPECT_GT(pads.frames.size(), 600u);
  pads.line.set_faults({});
  pads.run(10);
  EXPECT_EQ(pads.driver.state(), DriverState::kStreaming);
}

INSTANTIATE_TEST_SUITE_P(Lines, DsaBadLine,
                         ::testing::Values(LineFaults{.dropped = 0.1}, LineFaults{.corrupted = 0.3},
                                           LineFaults{.duplicated = 0.2},
                                           LineFaults{.late = 0.2, .delay = 50ms}));

TEST(DsaDriver, TenThousandStartsAndStopsLeaveNothingBehind) {
  DriverOptions options;
  ControllerOptions fast;
  fast.baud = 0;
  VirtualPads pads(options, fast);
  std::size_t in_use = 0;
  for (int i = 0; i < 10000; ++i) {
    pads.driver.connected(pads.now);
    pads.run(0.012);
    ASSERT_EQ(pads.driver.state(), DriverState::kStreaming) << i;
    pads.driver.stop(pads.now);
    ASSERT_FALSE(pads.controller.is_streaming());
    pads.run(0.002);
    pads.frames.clear();
    pads.problems.clear();
    if (i == 1000) in_use = mallinfo2().uordblks;
  }
  EXPECT_LT(mallinfo2().uordblks, in_use + 100000);
}

TEST(DsaDriver, OptionsOutOfRangeAreRefused) {
  const auto refused = [](auto change) {
    DriverOptions options;
    change(options);
    EXPECT_THROW(VirtualPads{options}, std::invalid_argument);
  };
  refused([](DriverOptions& o) { o.sensitivity = 1.1; });
  refused([](DriverOptions& o) { o.sensitivity = std::numeric_limits<double>::quiet_NaN(); });
  refused([](DriverOptions& o) { o.threshold = 4096; });
  refused([](DriverOptions& o) { o.frame_rate = 0; });
  refused([](DriverOptions& o) { o.stale_time = 0; });
  refused([](DriverOptions& o) { o.tries = 0; });
}

// --- over real lines --------------------------------------------------------------------------

TEST(DsaLines, SerialAndTcp) {
  for (const bool tcp : {false, true}) {
    std::unique_ptr<ByteStream> end;
    if (tcp) end = std::make_unique<TcpServer>();
    if (!tcp) end = std::make_unique<PseudoTerminal>();
    const std::string name = end->name();
    ServedDevice<Controller> controller(ControllerOptions{}, std::move(end));
    controller.with_device(
        [](Controller& c, Time) { c.set_texels(std::vector<std::uint16_t>(168, 9)); });
    std::atomic<int> frames = 0, wrong = 0;
    Notes notes;
    Device device(
        {}, [&] { return open_byte_stream(name, 115200); },
        [&](const Frame& frame, const std::vector<MatrixInfo>& matrices) {
          ++frames;
          wrong += matrices.size() != 2 || frame.texels[100] != 9;
        },
        notes.taker());
    EXPECT_TRUE(eventually([&] { return frames >= 30; }));
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(device.statistics().discarded, 0u);
  }
}

TEST(DsaLines, UnplugAndPlugAFullBufferAndDamage) {
  const auto link =
      std::filesystem::temp_directory_path() / ("prehend_dsa_" + std::to_string(::getpid()));
  auto terminal = std::make_unique<PseudoTerminal>(link);
  PseudoTerminal& plug = *terminal;
  auto faulty = std::make_unique<FaultyStream>(std::move(terminal));
  FaultyStream& faults = *faulty;
  ServedDevice<Controller> controller(ControllerOptions{}, std::move(faulty));
  std::atomic<int> frames = 0;
  Notes notes;
  DriverOptions options;
  options.reply_time = 0.1;
  Device device(
      options, [&] { return open_byte_stream(link, 115200); },
      [&](const Frame&, const std::vector<MatrixInfo>&) { ++frames; }, notes.taker(), 0.02);
  const auto streams = [&] {
    const int before = frames;
    return eventually([&] { return frames > before + 5; });
  };
  ASSERT_TRUE(streams());
  plug.unplug();
  ASSERT_TRUE(eventually([&] { return device.state() == DriverState::kDisconnected; }));
  EXPECT_TRUE(notes.has("is gone"));
  plug.plug();
  ASSERT_TRUE(streams());
  faults.set_faults({.dropped = 0.1, .duplicated = 0.1, .corrupted = 0.2});
  ASSERT_TRUE(streams());
  EXPECT_TRUE(eventually([&] { return device.statistics().bad_checksums > 0; }));
  faults.set_faults({});
  controller.set_deaf(true);
  controller.with_device([](Controller& c, Time) { c.set_silent(true); });
  ASSERT_TRUE(eventually([&] { return notes.has("no tactile frame"); }));
  controller.set_deaf(false);
  controller.with_device([](Controller& c, Time) { c.set_silent(false); });
  ASSERT_TRUE(streams());
}

}  // namespace
}  // namespace prehend::drivers::dsa
