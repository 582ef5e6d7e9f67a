#include <gtest/gtest.h>

#include <random>
#include <set>

#include "drivers/dsa/codec/frame.h"
#include "drivers/dsa/codec/packet.h"
#include "drivers/dsa/codec/structures.h"
#include "tests/drivers/hex.h"

namespace prehend::drivers::dsa {
namespace {

using Random = std::mt19937_64;

std::string packet_text(PacketId id, Bytes payload) {
  return to_hex(encode_packet(static_cast<std::uint8_t>(id), payload));
}

Packet decoded(const std::string& text) {
  PacketDecoder decoder;
  decoder.add(hex(text));
  const auto packet = decoder.next();
  EXPECT_TRUE(packet) << text;
  EXPECT_FALSE(decoder.is_partial());
  EXPECT_EQ(decoder.discarded(), 0u) << text;
  return packet.value_or(Packet{});
}

// Emitted by the vendor's program demo-dsa, or computed with the CRC of its library.
TEST(DsaVectors, AcquisitionRequests) {
  const struct {
    const char* text;
    Acquisition request;
  } vectors[] = {{"AA AA AA 03 03 00 01 00 00 2F 6A", {0x01, 0}},
                 {"AA AA AA 03 03 00 81 00 00 2F 68", {0x81, 0}},
                 {"AA AA AA 03 03 00 81 01 00 7C 5C", {0x81, 1}},
                 {"AA AA AA 03 03 00 81 1E 00 2C 76", {0x81, 30}},
                 {"AA AA AA 03 03 00 80 1E 00 8E 1C", {0x80, 30}}};
  for (const auto& vector : vectors) {
    EXPECT_EQ(packet_text(PacketId::kAcquisition, encode(vector.request)), vector.text);
    EXPECT_EQ(decode_acquisition(decoded(vector.text).payload), vector.request);
  }
}

TEST(DsaVectors, QueriesWithAndWithoutPayload) {
  EXPECT_EQ(packet_text(PacketId::kControllerInfo, {}), "AA AA AA 01 00 00");
  EXPECT_EQ(packet_text(PacketId::kMatrixInfo, hex("00")), "AA AA AA 0B 01 00 00 CB FB");
  EXPECT_EQ(packet_text(PacketId::kMatrixInfo, hex("01")), "AA AA AA 0B 01 00 01 EA EB");
  EXPECT_EQ(decoded("AA AA AA 0B 01 00 01 EA EB"), (Packet{0x0B, {1}}));
  EXPECT_EQ(decoded("AA AA AA 01 00 00"), (Packet{0x01, {}}));
}

TEST(DsaVectors, SensitivityAndThreshold) {
  const struct {
    const char* text;
    SetSensitivity request;
  } sensitivities[] = {{"AA AA AA 0F 06 00 00 00 00 00 40 3F 30 2A", {0, 0, 0.75F}},
                       {"AA AA AA 0F 06 00 00 01 00 00 40 3F AB D3", {0, 1, 0.75F}},
                       {"AA AA AA 0F 06 00 02 00 00 00 40 3F 56 78", {2, 0, 0.75F}}};
  for (const auto& vector : sensitivities) {
    EXPECT_EQ(packet_text(PacketId::kSetSensitivity, encode(vector.request)), vector.text);
    EXPECT_EQ(decode_set_sensitivity(decoded(vector.text).payload), vector.request);
  }
  const char* thresholds = "AA AA AA 13 04 00 02 00 C8 00 86 40";
  const SetThreshold all_200{AdjustFlags::kAllMatrices, 0, 200};
  EXPECT_EQ(packet_text(PacketId::kSetThreshold, encode(all_200)), thresholds);
  EXPECT_EQ(decode_set_threshold(decoded(thresholds).payload), all_200);
  EXPECT_EQ(packet_text(PacketId::kGetThreshold, hex("00")), "AA AA AA 14 01 00 00 03 C1");
  const char* answer = "AA AA AA 14 04 00 00 00 C8 00 DE 99";
  EXPECT_EQ(packet_text(PacketId::kGetThreshold, encode(ThresholdInfo{0, 200})), answer);
  EXPECT_EQ(decode_threshold_info(decoded(answer).payload), (ThresholdInfo{0, 200}));
}

TEST(DsaVectors, StatusAnswers) {
  EXPECT_EQ(packet_text(PacketId::kAcquisition, encode_status(0)), "AA AA AA 03 02 00 00 00 4B B9");
  EXPECT_EQ(packet_text(PacketId::kAcquisition, encode_status(11)),
            "AA AA AA 03 02 00 0B 00 37 64");
  EXPECT_EQ(decode_status(decoded("AA AA AA 03 02 00 0B 00 37 64").payload), 11);
}

TEST(DsaVectors, RunLengthCodedFrameOfAnEmptyPad) {
  const char* text = "AA AA AA 00 11 00 E8 03 00 00 01 00 F0 00 F0 00 F0 00 F0 00 F0 00 90 B3 A9";
  const Frame frame{1000, std::vector<std::uint16_t>(6 * 14)};
  EXPECT_EQ(packet_text(PacketId::kFrame, encode_frame(frame, true)), text);
  Frame received;
  ASSERT_TRUE(decode_frame(decoded(text).payload, 6 * 14, received));
  EXPECT_EQ(received, frame);
}

TEST(DsaVectors, ControllerInfoHasEighteenBytes) {
  const char* text =
      "AA AA AA 01 12 00 00 00 D2 04 00 00 10 2C 01 00 00 00 00 00 00 00 00 00 5D 44";
  ControllerInfo info;
  info.serial = 1234;
  info.hardware = 0x10;
  info.software = 300;
  EXPECT_EQ(packet_text(PacketId::kControllerInfo, encode(info)), text);
  auto payload = decoded(text).payload;
  EXPECT_EQ(decode_controller_info(payload), info);
  payload.push_back(0);  // the library's 19
  EXPECT_EQ(decode_controller_info(payload), info);
  payload.push_back(0);
  EXPECT_FALSE(decode_controller_info(payload));
}

TEST(DsaStructures, SizesOfTheVendorsLibrary) {
  EXPECT_EQ(encode(SensorInfo{}).size(), 12u);
  EXPECT_EQ(encode(MatrixInfo{}).size(), 52u);
  EXPECT_EQ(encode(SensitivityInfo{}).size(), 11u);
  MatrixInfo matrix;
  matrix.texel_width = matrix.texel_height = 3.4F;
  matrix.cells_x = 6;
  matrix.cells_y = 14;
  matrix.uid = {1, 2, 3, 4, 5, 6};
  matrix.centre = {1, 2, 3};
  matrix.full_scale = 250;
  EXPECT_EQ(decode_matrix_info(encode(matrix)), matrix);
  const SensorInfo sensor{0, 6, 1, 2, 99, 3};
  EXPECT_EQ(decode_sensor_info(encode(sensor)), sensor);
  const SensitivityInfo sensitivity{0, 2, 0.75F, 0.5F};
  EXPECT_EQ(decode_sensitivity_info(encode(sensitivity)), sensitivity);
  EXPECT_FALSE(decode_matrix_info(hex("00 00 01")));
  EXPECT_EQ(decode_threshold_info(encode_status(13)), (ThresholdInfo{13, 0}));
}

TEST(DsaStructures, EveryStatusHasWordsOfItsOwn) {
  std::set<std::string> seen;
  for (std::uint16_t status = 0; status < kStatusCount; ++status) {
    EXPECT_TRUE(seen.insert(describe_status(status)).second);
  }
  EXPECT_EQ(describe_status(11), "checksum error (11)");
  EXPECT_EQ(describe_status(17), "command failed (17)");
  EXPECT_EQ(describe_status(27), "range error (27)");
  EXPECT_EQ(describe_status(77), "unknown status (77)");
}

Frame random_frame(Random& random, std::size_t texels) {
  Frame frame{static_cast<std::uint32_t>(random()), {}};
  while (frame.texels.size() < texels) {
    const auto value = static_cast<std::uint16_t>(random() % 3 == 0 ? random() % 4096 : 0);
    frame.texels.resize(std::min(texels, frame.texels.size() + 1 + random() % 20), value);
  }
  return frame;
}

TEST(DsaFrames, RandomFramesThroughBothCodings) {
  Random random(3);
  Frame received;
  for (int i = 0; i < 1000000; ++i) {
    const std::size_t texels = i % 1000 == 0 ? 486 : random() % 40;
    const Frame frame = random_frame(random, texels);
    const auto runs = encode_frame(frame, true);
    ASSERT_LE(runs.size(), 5 + 2 * texels);
    ASSERT_TRUE(decode_frame(runs, texels, received));
    ASSERT_EQ(received, frame);
    const auto raw = encode_frame(frame, false);
    ASSERT_EQ(raw.size(), 5 + 2 * texels);
    ASSERT_TRUE(decode_frame(raw, texels, received));
    ASSERT_EQ(received, frame);
  }
}

TEST(DsaFrames, WhatDoesNotHoldExactlyTheTexelsIsRefused) {
  Frame frame;
  EXPECT_FALSE(decode_frame({}, 84, frame));
  EXPECT_FALSE(decode_frame(hex("E8 03 00 00"), 84, frame));
  EXPECT_FALSE(decode_frame(hex("E8 03 00 00 01 00 F0"), 84, frame));    // too few
  EXPECT_FALSE(decode_frame(hex("E8 03 00 00 01 00 F0"), 14, frame));    // too many
  EXPECT_FALSE(decode_frame(hex("E8 03 00 00 01 00 00"), 1, frame));     // a run of 0
  EXPECT_FALSE(decode_frame(hex("E8 03 00 00 01 00 10 00"), 1, frame));  // half a unit
  EXPECT_FALSE(decode_frame(hex("E8 03 00 00 00 00 10"), 1, frame));     // 4096
  EXPECT_FALSE(decode_frame(hex("E8 03 00 00 00 00 00 00 00"), 1, frame));
  EXPECT_TRUE(decode_frame(hex("E8 03 00 00 00 FF 0F"), 1, frame));
  EXPECT_TRUE(decode_frame(hex("E8 03 00 00 01"), 0, frame));
  EXPECT_THROW(encode_frame({0, {4096}}, true), std::invalid_argument);
}

TEST(DsaPackets, StartUpTextAndGarbageAreSkippedAndNoPacketIsLost) {
  Random random(4);
  PacketDecoder decoder;
  decoder.add(hex("1B 5B 35 6E 1B 5B 35 6E 1B 5B 35 6E"));
  std::uint64_t garbage = 12;
  for (int i = 0; i < 100000; ++i) {
    Packet packet{static_cast<std::uint8_t>(random()), {}};
    packet.payload.resize(random() % 60);
    for (auto& byte : packet.payload) {
      byte = static_cast<std::uint8_t>(random() % 4 ? random() : 0xAA);
    }
    for (auto n = random() % 5; n > 0; --n) {
      const std::uint8_t byte[] = {static_cast<std::uint8_t>(random() % 0xAA)};
      decoder.add(byte);
      ++garbage;
    }
    const auto bytes = encode_packet(packet.id, packet.payload);
    const std::size_t cut = random() % bytes.size();
    decoder.add(Bytes(bytes).first(cut));
    ASSERT_FALSE(decoder.next());
    decoder.add(Bytes(bytes).subspan(cut));
    ASSERT_EQ(decoder.next(), packet) << i;
  }
  EXPECT_EQ(decoder.discarded(), garbage);
  EXPECT_EQ(decoder.bad_checksums(), 0u);
}

TEST(DsaPackets, ThePacketBehindADamagedOneIsFound) {
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    const Frame frame = random_frame(random, 84);
    auto damaged = encode_packet(0, encode_frame(frame, true));
    damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1 + random() % 255);
    const Packet wanted{0x03, encode_status(0)};
    PacketDecoder decoder(1024);
    decoder.add(damaged);
    decoder.add(encode_packet(wanted.id, wanted.payload));
    bool found = false;
    for (int silences = 0; silences < 400 && !found; ++silences) {
      while (const auto packet = decoder.next()) {
        found |= *packet == wanted;
        Frame seen;
        if (!found && packet->id == 0 && decode_frame(packet->payload, 84, seen)) {
          ASSERT_EQ(seen, frame);  // damage must not look like another frame
        }
      }
      if (!found) decoder.give_up();
    }
    ASSERT_TRUE(found) << i;
  }
}

TEST(DsaPackets, BoundsOfSizes) {
  EXPECT_THROW(encode_packet(6, std::vector<std::uint8_t>(65536)), std::length_error);
  PacketDecoder decoder(16);
  decoder.add(encode_packet(6, std::vector<std::uint8_t>(17)));
  EXPECT_FALSE(decoder.next());
  EXPECT_GT(decoder.discarded(), 0u);
  PacketDecoder large(65535);
  large.add(encode_packet(6, std::vector<std::uint8_t>(65535, 0xAA)));
  ASSERT_TRUE(large.next());
}

}  // namespace
}  // namespace prehend::drivers::dsa
