#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <numeric>
#include <thread>
#include <vector>

#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/tcp_server.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers {
namespace {

using namespace std::chrono_literals;

std::vector<std::uint8_t> read_all(ByteStream& stream, std::size_t count) {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 100> buffer;
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (bytes.size() < count && std::chrono::steady_clock::now() < end) {
    const IoResult result = stream.read(buffer, 50ms);
    if (result.status == IoStatus::kClosed) break;
    bytes.insert(bytes.end(), buffer.begin(),
                 buffer.begin() + static_cast<std::ptrdiff_t>(result.count));
  }
  return bytes;
}

// All byte values, several times: nothing may be translated or eaten on the way.
std::vector<std::uint8_t> all_bytes() {
  std::vector<std::uint8_t> bytes(1024);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

void check_both_ways(ByteStream& device, ByteStream& driver) {
  const auto bytes = all_bytes();
  ASSERT_EQ(driver.write(bytes, 1s).status, IoStatus::kOk);
  EXPECT_EQ(read_all(device, bytes.size()), bytes);
  ASSERT_EQ(device.write(bytes, 1s).status, IoStatus::kOk);
  EXPECT_EQ(read_all(driver, bytes.size()), bytes);
  std::array<std::uint8_t, 4> buffer;
  EXPECT_EQ(driver.read(buffer, 1ms).status, IoStatus::kTimeout);
}

TEST(Streams, SerialLineCarriesEveryByte) {
  PseudoTerminal device;
  const auto driver = open_byte_stream(device.name(), 115200);
  check_both_ways(device, *driver);
}

TEST(Streams, TcpCarriesEveryByteAndServesTheNextClient) {
  TcpServer device;
  std::array<std::uint8_t, 16> buffer;
  for (int client = 0; client < 3; ++client) {
    const auto driver = open_byte_stream(device.name(), 0);
    device.read(buffer, 1s);  // takes the connection
    check_both_ways(device, *driver);
    device.disconnect();
    EXPECT_EQ(driver->read(buffer, 1s).status, IoStatus::kClosed);
  }
}

TEST(Streams, FullBufferIsATimeoutNotAHang) {
  PseudoTerminal device;  // nobody reads it
  const auto driver = open_byte_stream(device.name(), 115200);
  const std::vector<std::uint8_t> bytes(1 << 20);
  const IoResult result = driver->write(bytes, 20ms);
  EXPECT_EQ(result.status, IoStatus::kTimeout);
  EXPECT_LT(result.count, bytes.size());
  EXPECT_EQ(result.problem, "the line does not take more bytes");
}

TEST(Streams, UnpluggedLineIsClosedAndOpensAgainUnderItsName) {
  const auto link =
      std::filesystem::temp_directory_path() / ("prehend_line_" + std::to_string(::getpid()));
  PseudoTerminal device(link);
  EXPECT_EQ(device.name(), link);
  for (int i = 0; i < 20; ++i) {
    const auto driver = open_byte_stream(link, 115200);
    device.unplug();
    EXPECT_FALSE(std::filesystem::exists(link));
    std::array<std::uint8_t, 4> buffer;
    EXPECT_EQ(driver->read(buffer, 1s).status, IoStatus::kClosed);
    EXPECT_EQ(driver->write(buffer, 10ms).status, IoStatus::kClosed);
    EXPECT_THROW(open_byte_stream(link, 115200), geometry::InputError);
    device.plug();
  }
  check_both_ways(device, *open_byte_stream(link, 115200));
}

std::string error_of(const std::string& address) {
  try {
    open_byte_stream(address, 115200, 200ms);
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Streams, ErrorsNameTheLineAndTheMend) {
  EXPECT_EQ(error_of(""), "no serial line is named. Give /dev/... or tcp://HOST:PORT.");
  EXPECT_EQ(error_of("/dev/no_such_line"),
            "cannot open /dev/no_such_line: No such file or directory. Check plug and name (ls "
            "/dev/serial/by-id).");
  EXPECT_NE(error_of("/dev/null").find("cannot open /dev/null: Inappropriate ioctl"),
            std::string::npos);
  EXPECT_EQ(error_of("tcp://host"), "'tcp://host' is no address. Write tcp://HOST:PORT.");
  EXPECT_NE(error_of("tcp://127.0.0.1:1").find("Connection refused. Check that the device is on"),
            std::string::npos);
  TcpServer server;
  const auto port = server.name().substr(server.name().rfind(':') + 1);
  EXPECT_THROW(TcpServer(static_cast<std::uint16_t>(std::stoi(port))), geometry::InputError);
}

}  // namespace
}  // namespace prehend::drivers
