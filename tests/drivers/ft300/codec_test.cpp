#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "drivers/ft300/codec/measurement.h"
#include "drivers/ft300/codec/modbus_rtu.h"
#include "tests/drivers/hex.h"

namespace prehend::drivers::ft300 {
namespace {

using Random = std::mt19937_64;

const Measurement kMeasurement{{12.34, -5.67, 25.00}, {-0.012, 0.345, -0.678}};

// Sent by the vendor's driver, or accepted by it.
TEST(Ft300Vectors, RequestsBothWays) {
  const struct {
    const char* text;
    ModbusRequest request;
  } vectors[] = {{"09 03 01 F4 00 01 C5 4C", ReadRequest{registers::kFirmware, 1}},
                 {"09 03 01 F4 00 03 44 8D", ReadRequest{registers::kFirmware, 3}},
                 {"09 03 02 02 00 01 25 3A", ReadRequest{registers::kYear, 1}},
                 {"09 03 01 FE 00 04 25 4D", ReadRequest{registers::kSerial, 4}},
                 {"09 03 00 B4 00 06 84 A6", ReadRequest{registers::kForce, 6}},
                 {"09 10 01 9A 00 01 02 02 00 CD CA",
                  WriteRequest{registers::kOutputSelect, {registers::kStartStream}}}};
  for (const auto& vector : vectors) {
    EXPECT_EQ(to_hex(encode_rtu(9, encode_pdu(vector.request))), vector.text);
    const auto message = decode_rtu(hex(vector.text));
    ASSERT_TRUE(message) << vector.text;
    EXPECT_EQ(message->unit, 9);
    EXPECT_EQ(decode_request_pdu(message->pdu), vector.request);
    RtuRequestDecoder decoder;
    decoder.add(hex(vector.text));
    EXPECT_EQ(decoder.next(), message);
  }
}

TEST(Ft300Vectors, RepliesBothWays) {
  const struct {
    const char* text;
    ModbusReply reply;
  } vectors[] = {{"09 03 02 46 54 6A 1A", ReadReply{{0x4654}}},
                 {"09 03 06 46 54 53 02 00 01 08 9B", ReadReply{{0x4654, 0x5302, 0x0001}}},
                 {"09 03 02 07 E2 DB FC", ReadReply{{2018}}},
                 {"09 10 01 9A 00 01 21 52", WriteReply{registers::kOutputSelect, 1}},
                 {"09 03 0C 04 D2 FD C9 09 C4 FF F4 01 59 FD 5A 96 96",
                  ReadReply{{0x04D2, 0xFDC9, 0x09C4, 0xFFF4, 0x0159, 0xFD5A}}},
                 {"09 83 02 41 33", ExceptionReply{0x03, ModbusException::kIllegalAddress}}};
  for (const auto& vector : vectors) {
    EXPECT_EQ(to_hex(encode_rtu(9, encode_pdu(vector.reply))), vector.text);
    const auto message = decode_rtu(hex(vector.text));
    ASSERT_TRUE(message) << vector.text;
    EXPECT_EQ(decode_reply_pdu(message->pdu), vector.reply);
  }
}

TEST(Ft300Vectors, MeasurementAsRegistersAndAsStream) {
  const MeasurementRegisters values{0x04D2, 0xFDC9, 0x09C4, 0xFFF4, 0x0159, 0xFD5A};
  EXPECT_EQ(to_registers(kMeasurement), values);
  EXPECT_EQ(from_registers(values), kMeasurement);
  const char* text = "20 4E D2 04 C9 FD C4 09 F4 FF 59 01 5A FD E8 DF";
  EXPECT_EQ(to_hex(encode_stream(kMeasurement)), text);
  StreamDecoder decoder;
  decoder.add(hex(text));
  EXPECT_EQ(decoder.next(), kMeasurement);
  EXPECT_EQ(decoder.discarded(), 0u);
}

TEST(Ft300Vectors, FirmwareAndSerialNumber) {
  EXPECT_EQ(firmware_text({0x4654, 0x5302, 0x0001}), "FTS-2.0.1");
  EXPECT_TRUE(is_force_sensor({0x4654, 0x5302, 0x0001}));
  EXPECT_FALSE(is_force_sensor({0x5247, 0, 0}));
  EXPECT_EQ(serial_text({0x4142, 0x4300, 0x3039, 0x0000}), "ABC-00012345");
  EXPECT_EQ(serial_text({0, 0, 1, 1}),
            "?"
            "?"
            "?-00065537");
}

TEST(Ft300Codec, ValuesBeyondTheWireAreCutAndNanIsZero) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Measurement hostile{{1e9, -infinity, std::nan("")}, {infinity, -33, 32.7674}};
  const Measurement cut = from_registers(to_registers(hostile));
  EXPECT_EQ(cut.force, (std::array<double, 3>{327.67, -327.68, 0}));
  EXPECT_EQ(cut.torque, (std::array<double, 3>{32.767, -32.768, 32.767}));
}

MeasurementRegisters random_values(Random& random) {
  MeasurementRegisters values;
  for (auto& value : values) value = static_cast<std::uint16_t>(random());
  return values;
}

TEST(Ft300Codec, MillionRandomMeasurementsThroughRegistersAndStream) {
  Random random(1);
  StreamDecoder decoder;
  for (int i = 0; i < 1000000; ++i) {
    const MeasurementRegisters values = random_values(random);
    const Measurement measurement = from_registers(values);
    ASSERT_EQ(to_registers(measurement), values) << i;
    decoder.add(encode_stream(measurement));
    ASSERT_EQ(decoder.next(), measurement) << i;
  }
  EXPECT_EQ(decoder.discarded(), 0u);
}

TEST(Ft300Codec, StreamWithGarbageBetweenMessagesLosesNone) {
  Random random(2);
  StreamDecoder decoder;
  std::uint64_t garbage = 0;
  for (int i = 0; i < 100000; ++i) {
    for (auto n = random() % 20; n > 0; --n) {
      const std::uint8_t byte[] = {static_cast<std::uint8_t>(0x21 + random() % 200)};
      decoder.add(byte);
      ++garbage;
    }
    const Measurement measurement = from_registers(random_values(random));
    const auto bytes = encode_stream(measurement);
    const std::size_t cut = random() % bytes.size();
    decoder.add(Bytes(bytes).first(cut));
    ASSERT_FALSE(decoder.next());
    decoder.add(Bytes(bytes).subspan(cut));
    ASSERT_EQ(decoder.next(), measurement) << i;
  }
  EXPECT_EQ(decoder.discarded(), garbage);
}

TEST(Ft300Codec, DamagedStreamMessageIsNoMeasurementAndTheNextIsFound) {
  Random random(3);
  for (int i = 0; i < 100000; ++i) {
    const Measurement second = from_registers(random_values(random));
    auto damaged = encode_stream(from_registers(random_values(random)));
    damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
    StreamDecoder decoder;
    decoder.add(damaged);
    decoder.add(encode_stream(second));
    ASSERT_EQ(decoder.next(), second) << i;
  }
}

TEST(Ft300Codec, RandomModbusMessagesBothWays) {
  Random random(4);
  for (int i = 0; i < 1000000; ++i) {
    const auto address = static_cast<std::uint16_t>(random());
    ModbusRequest request = ReadRequest{address, static_cast<std::uint16_t>(1 + random() % 125)};
    ModbusReply reply = WriteReply{address, static_cast<std::uint16_t>(random())};
    if (random() % 2) {
      std::vector<std::uint16_t> values(1 + random() % 6);
      for (auto& value : values) value = static_cast<std::uint16_t>(random());
      request = WriteRequest{address, values};
      reply = ReadReply{values};
    }
    const auto rtu = decode_rtu(encode_rtu(9, encode_pdu(request)));
    ASSERT_TRUE(rtu);
    ASSERT_EQ(decode_request_pdu(rtu->pdu), request);
    ASSERT_EQ(decode_reply_pdu(encode_pdu(reply)), reply);
    bool broken = false;
    auto tcp = encode_tcp(address, 9, encode_pdu(request));
    const auto taken = take_tcp(tcp, broken);
    ASSERT_TRUE(taken && !broken && tcp.empty());
    ASSERT_EQ(taken->transaction, address);
    ASSERT_EQ(decode_request_pdu(taken->pdu), request);
  }
}

TEST(Ft300Codec, ContradictingModbusMessagesAreRefused) {
  EXPECT_FALSE(decode_request_pdu({}));
  EXPECT_FALSE(decode_request_pdu(hex("03 00 B4 00 00")));           // none
  EXPECT_FALSE(decode_request_pdu(hex("03 00 B4 00 7E")));           // 126
  EXPECT_FALSE(decode_request_pdu(hex("03 00 B4 00")));              // cut off
  EXPECT_FALSE(decode_request_pdu(hex("10 01 9A 00 01 04 02 00")));  // counts contradict
  EXPECT_EQ(decode_request_pdu(hex("2B 0E")), ModbusRequest(UnknownRequest{0x2B}));
  EXPECT_FALSE(decode_reply_pdu(hex("03 03 00 00 00")));
  EXPECT_FALSE(decode_reply_pdu(hex("83")));
  EXPECT_FALSE(decode_rtu(hex("09 03")));
  bool broken = false;
  auto bytes = hex("00 01 00 01 00 06 09 03 00 B4 00 06");  // protocol 1
  EXPECT_FALSE(take_tcp(bytes, broken));
  EXPECT_TRUE(broken);
  bytes = hex("00 01 00 00 00 06 09 03");
  EXPECT_FALSE(take_tcp(bytes, broken));
  EXPECT_FALSE(broken);
}

}  // namespace
}  // namespace prehend::drivers::ft300
