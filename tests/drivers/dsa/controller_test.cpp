// The emulated controller by itself, with the quirks of the real firmware.

#include "drivers/dsa/emulator/controller.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace prehend::drivers::dsa {
namespace {

class DsaController {
 public:
  explicit DsaController(ControllerOptions options = {}) {
    options.baud = 0;
    controller =
        std::make_unique<Controller>(options, [this](Bytes bytes) { decoder_.add(bytes); });
  }
  std::vector<Packet> ask(PacketId id, const Payload& payload) {
    controller->receive(encode_packet(static_cast<std::uint8_t>(id), payload), now);
    return run(0.005);
  }
  std::vector<Packet> run(double seconds) {
    std::vector<Packet> packets;
    const Time end = now + to_time(seconds);
    while (now < end) {
      now += std::chrono::milliseconds(1);
      controller->update(now);
      while (auto packet = decoder_.next()) packets.push_back(*packet);
    }
    return packets;
  }
  std::uint16_t status(PacketId id, const Payload& payload) {
    const auto answers = ask(id, payload);
    EXPECT_EQ(answers.size(), 1u);
    return answers.empty() ? 999 : decode_status(answers[0].payload).value_or(998);
  }

  Time now = std::chrono::seconds(3);
  std::unique_ptr<Controller> controller;

 private:
  PacketDecoder decoder_;
};

TEST(DsaController, PersistentSettingsAreNotAnswered) {
  DsaController c;
  const SetSensitivity keep{AdjustFlags::kPersistent | AdjustFlags::kAllMatrices, 0, 0.75F};
  EXPECT_TRUE(c.ask(PacketId::kSetSensitivity, encode(keep)).empty());
  const auto info = c.ask(PacketId::kGetSensitivity, {1});
  EXPECT_EQ(decode_sensitivity_info(info.at(0).payload)->current, 0.75F);  // but done
}

TEST(DsaController, OldFirmwareHasNoThresholdsAndNoSingleFrames) {
  ControllerOptions old;
  old.firmware = 260;
  DsaController c(old);
  EXPECT_EQ(c.status(PacketId::kSetThreshold, encode(SetThreshold{2, 0, 5})), 13);
  EXPECT_EQ(c.status(PacketId::kSetSensitivity, encode(SetSensitivity{2, 0, 0.75F})), 0);
  const auto info = c.ask(PacketId::kGetSensitivity, {0});
  EXPECT_EQ(decode_sensitivity_info(info.at(0).payload)->current, 0.5F);  // always
  c.ask(PacketId::kAcquisition, encode(Acquisition{0x81, 0}));
  EXPECT_GT(c.run(1).size(), 20u);  // streams on although one was asked for
  DsaController newer;
  EXPECT_EQ(newer.ask(PacketId::kAcquisition, encode(Acquisition{0x81, 0})).size(), 2u);
  EXPECT_TRUE(newer.run(1).empty());
}

TEST(DsaController, OlderClientsFlagIsAccepted) {
  DsaController c;
  c.ask(PacketId::kAcquisition, encode(Acquisition{0xA1, 30}));  // RobWork sets bit 5, too
  EXPECT_TRUE(c.controller->is_streaming());
  c.ask(PacketId::kAcquisition, encode(Acquisition{0x01, 0}));
  EXPECT_FALSE(c.controller->is_streaming());
}

TEST(DsaController, AnswersErrors) {
  DsaController c;
  EXPECT_EQ(c.status(PacketId::kMatrixInfo, {2}), 24);
  EXPECT_EQ(c.status(PacketId::kSetSensitivity, encode(SetSensitivity{0, 5, 0.5F})), 24);
  EXPECT_EQ(c.status(PacketId::kSetSensitivity, encode(SetSensitivity{0, 0, 1.5F})), 27);
  EXPECT_EQ(c.status(PacketId::kSetThreshold, encode(SetThreshold{0, 0, 5000})), 27);
  EXPECT_EQ(c.status(PacketId::kSetThreshold, {1}), 12);
  EXPECT_EQ(c.status(PacketId::kAcquisition, {1}), 12);
  EXPECT_EQ(c.status(PacketId::kControllerFeatures, {}), 13);
  auto damaged = encode_packet(3, encode(Acquisition{0x81, 30}));
  damaged[7] ^= 1;
  c.controller->receive(damaged, c.now);
  const auto answers = c.run(0.005);
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(decode_status(answers[0].payload), 11);
  EXPECT_FALSE(c.controller->is_streaming());
}

TEST(DsaController, EchoesAndRefusesImpossibleShapes) {
  DsaController c;
  EXPECT_EQ(c.ask(PacketId::kLoop, {1, 2, 3}).at(0).payload, (Payload{1, 2, 3}));
  EXPECT_EQ(c.ask(PacketId::kLoop, {}).at(0).payload, Payload{});
  ControllerOptions none;
  none.matrices.clear();
  EXPECT_THROW(DsaController{none}, std::invalid_argument);
  none.matrices = {{0, 5, 3.4}};
  EXPECT_THROW(DsaController{none}, std::invalid_argument);
  EXPECT_THROW(c.controller->set_texels({1, 2}), std::invalid_argument);
}

TEST(DsaMatrixShape, IsReadFromText) {
  const MatrixShape proximal = matrix_shape_from("6x14"), other = matrix_shape_from("12x3@2.5");
  EXPECT_EQ(proximal.cells_x, 6);
  EXPECT_EQ(proximal.cells_y, 14);
  EXPECT_EQ(proximal.texel_pitch, 3.4);
  EXPECT_EQ(other.cells_x, 12);
  EXPECT_EQ(other.cells_y, 3);
  EXPECT_EQ(other.texel_pitch, 2.5);
  for (const char* bad : {"", "6", "6x", "x14", "6x14@", "6x14@-1", "0x14", "6x256", "6x14 ",
                          "6X14", "6x14@3.4mm", "-6x14", "6x14@nan"}) {
    EXPECT_THROW(matrix_shape_from(bad), std::invalid_argument) << bad;
  }
}

// Any set of matrices, as those of an SDH-2, is told and streamed.
TEST(DsaController, HasWhateverMatricesItIsGiven) {
  ControllerOptions options;
  options.matrices.clear();
  for (const char* text : {"6x14", "6x13", "6x14", "6x13", "6x14", "6x13"}) {
    options.matrices.push_back(matrix_shape_from(text));
  }
  DsaController c(options);
  EXPECT_EQ(c.controller->texels(), 3u * 84 + 3u * 78);
  const auto answers = c.ask(PacketId::kMatrixInfo, {5});
  ASSERT_EQ(answers.size(), 1u);
  const auto info = decode_matrix_info(answers[0].payload);
  ASSERT_TRUE(info);
  EXPECT_EQ(info->cells_x, 6);
  EXPECT_EQ(info->cells_y, 13);
}

}  // namespace
}  // namespace prehend::drivers::dsa
