#include "drivers/wire/stream/byte_stream.h"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/serial_port.hpp>
#include <cerrno>
#include <cstring>
#include <type_traits>

#include "prehend/geometry/errors.h"

namespace prehend::drivers {
namespace {

namespace asio = boost::asio;
using std::chrono::steady_clock;

// True when the descriptor is ready (or broken, which the next call will tell).
bool wait_for(int descriptor, short events, steady_clock::time_point end) {
  while (true) {
    const auto left = std::max(end - steady_clock::now(), steady_clock::duration::zero());
    const timespec timeout{std::chrono::duration_cast<std::chrono::seconds>(left).count(),
                           (left % std::chrono::seconds(1)).count()};
    pollfd file{descriptor, events, 0};
    const int count = ::ppoll(&file, 1, &timeout, nullptr);
    if (count >= 0) return count > 0;
    if (errno != EINTR) return true;
  }
}

IoResult closed(const char* words) { return {IoStatus::kClosed, 0, words}; }

template <class Port>
class AsioStream : public ByteStream {
 public:
  explicit AsioStream(std::string name) : name_(std::move(name)), port_(context_) {}
  IoResult read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) override {
    return read_descriptor(port_.native_handle(), buffer, timeout);
  }
  IoResult write(Bytes bytes, std::chrono::nanoseconds timeout) override {
    return write_descriptor(port_.native_handle(), bytes, timeout);
  }
  std::string set_baud(unsigned baud) override {
    boost::system::error_code error;
    if constexpr (std::is_same_v<Port, asio::serial_port>) {
      port_.set_option(asio::serial_port_base::baud_rate(baud), error);
    }
    return error
               ? name_ + " refuses a baud rate of " + std::to_string(baud) + ": " + error.message()
               : "";
  }
  const std::string& name() const override { return name_; }

  std::string name_;
  asio::io_context context_;
  Port port_;
};

std::unique_ptr<ByteStream> open_serial(const std::string& device, unsigned baud) {
  auto stream = std::make_unique<AsioStream<asio::serial_port>>(device);
  boost::system::error_code error;
  stream->port_.open(device, error);
  if (error == boost::system::errc::permission_denied) throw_no_permission(device);
  if (error) {
    throw geometry::InputError("cannot open " + device + ": " + error.message(),
                               "Check plug and name (ls /dev/serial/by-id)");
  }
  using Port = asio::serial_port_base;
  const auto set = [&](const auto& option, const char* what) {
    stream->port_.set_option(option, error);
    if (error) {
      throw geometry::InputError(device + " refuses " + what + ": " + error.message(),
                                 "Use a serial line that offers it");
    }
  };
  set(Port::baud_rate(baud), ("a baud rate of " + std::to_string(baud)).c_str());
  set(Port::character_size(8), "8 data bits");
  set(Port::parity(Port::parity::none), "no parity");
  set(Port::stop_bits(Port::stop_bits::one), "one stop bit");
  set(Port::flow_control(Port::flow_control::none), "no flow control");
  ::tcflush(stream->port_.native_handle(), TCIOFLUSH);
  return stream;
}

std::unique_ptr<ByteStream> open_tcp(const std::string& address, std::chrono::nanoseconds timeout) {
  constexpr std::size_t kPrefix = 6;  // tcp://
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon <= kPrefix || colon + 1 == address.size()) {
    throw geometry::InputError("'" + address + "' is no address", "Write tcp://HOST:PORT");
  }
  using asio::ip::tcp;
  auto stream = std::make_unique<AsioStream<tcp::socket>>(address);
  boost::system::error_code error;
  tcp::resolver resolver(stream->context_);
  const auto endpoints =
      resolver.resolve(address.substr(kPrefix, colon - kPrefix), address.substr(colon + 1), error);
  if (!error) {
    error = asio::error::would_block;
    asio::async_connect(
        stream->port_, endpoints,
        [&](const boost::system::error_code& result, const tcp::endpoint&) { error = result; });
    stream->context_.run_for(timeout);
    if (error == asio::error::would_block) {
      stream->port_.close();
      stream->context_.run();  // ends the attempt, whose handler refers to this frame
      error = asio::error::timed_out;
    }
  }
  if (error) {
    throw geometry::InputError("cannot connect to " + address + ": " + error.message(),
                               "Check that the device is on, its address and its port");
  }
  stream->port_.set_option(tcp::no_delay(true), error);
  stream->port_.native_non_blocking(true, error);
  return stream;
}

}  // namespace

void throw_no_permission(const std::string& device) {
  throw geometry::InputError("no permission to open " + device,
                             "Add yourself to the group that owns it (ls -l " + device +
                                 "), as a rule 'sudo usermod -aG dialout $USER', and log in again");
}

IoResult read_descriptor(int descriptor, std::span<std::uint8_t> buffer,
                         std::chrono::nanoseconds timeout) {
  if (!wait_for(descriptor, POLLIN, steady_clock::now() + timeout)) return {};
  const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
  if (count > 0) return {IoStatus::kOk, static_cast<std::size_t>(count), {}};
  if (count == 0) return closed("the other side closed it");
  if (errno == EAGAIN || errno == EINTR) return {};
  return closed(std::strerror(errno));
}

IoResult write_descriptor(int descriptor, Bytes bytes, std::chrono::nanoseconds timeout) {
  const auto end = steady_clock::now() + timeout;
  IoResult result;
  while (result.count < bytes.size()) {
    const Bytes rest = bytes.subspan(result.count);
    const ssize_t count = ::write(descriptor, rest.data(), rest.size());
    if (count > 0) {
      result.count += static_cast<std::size_t>(count);
    } else if (count < 0 && errno != EAGAIN && errno != EINTR) {
      result.status = IoStatus::kClosed;
      result.problem = std::strerror(errno);
      return result;
    } else if (!wait_for(descriptor, POLLOUT, end)) {
      result.problem = "the line does not take more bytes";
      return result;
    }
  }
  result.status = IoStatus::kOk;
  return result;
}

std::unique_ptr<ByteStream> open_byte_stream(const std::string& address, unsigned baud,
                                             std::chrono::nanoseconds timeout) {
  if (address.starts_with("tcp://")) return open_tcp(address, timeout);
  if (address.empty()) {
    throw geometry::InputError("no serial line is named", "Give /dev/... or tcp://HOST:PORT");
  }
  return open_serial(address, baud);
}

}  // namespace prehend::drivers
