#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers {

/// How a read or a write ended.
enum class IoStatus {
  kOk,
  kTimeout,  ///< nothing came, or the other side did not take all bytes in time
  kClosed,   ///< the line is gone (unplugged, connection closed); open another stream
};

struct IoResult {
  IoStatus status = IoStatus::kTimeout;
  std::size_t count = 0;  // bytes read or written
  std::string problem;    // why it is closed, one line
};

/// A two-way stream of bytes: a serial line, a TCP connection, a pseudo-terminal. One thread may
/// read while another writes.
class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Waits until something is there, at most `timeout`, and reads what fits.
  virtual IoResult read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) = 0;
  /// Writes all bytes, waiting at most `timeout` for the line to take them.
  virtual IoResult write(Bytes bytes, std::chrono::nanoseconds timeout) = 0;
  /// Changes the rate [bit/s] of a serial line; "" or why it could not. What has no rate takes any.
  virtual std::string set_baud(unsigned /*baud*/) { return {}; }
  /// What it is, for messages: "/dev/ttyUSB0", "tcp://10.0.0.2:13000".
  virtual const std::string& name() const = 0;
};

/// Opens a serial line "/dev/..." with `baud` bits/s, 8N1, no flow control, or a TCP connection
/// "tcp://HOST:PORT" (`timeout` to connect; `baud` is not used). What had arrived on a serial line
/// before is discarded.
/// @throws geometry::InputError naming the line and the mend: no such device, no permission, not a
/// terminal, connection refused.
std::unique_ptr<ByteStream> open_byte_stream(
    const std::string& address, unsigned baud,
    std::chrono::nanoseconds timeout = std::chrono::seconds(1));

/// @throws geometry::InputError that `device` may not be opened by this user, and the mend.
[[noreturn]] void throw_no_permission(const std::string& device);

/// Reads from a file descriptor that does not block. Shared by all streams.
IoResult read_descriptor(int descriptor, std::span<std::uint8_t> buffer,
                         std::chrono::nanoseconds timeout);
IoResult write_descriptor(int descriptor, Bytes bytes, std::chrono::nanoseconds timeout);

}  // namespace prehend::drivers
