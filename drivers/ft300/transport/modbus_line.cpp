#include "drivers/ft300/transport/modbus_line.h"

#include <modbus/modbus.h>

#include <cerrno>

#include "drivers/wire/stream/byte_stream.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::ft300 {

struct ModbusLine::Context {
  modbus_t* modbus = nullptr;
  Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() {
    if (!modbus) return;
    modbus_close(modbus);
    modbus_free(modbus);
  }
};

ModbusLine::ModbusLine(const std::string& address, unsigned baud, std::uint8_t unit,
                       std::chrono::microseconds reply_time)
    : context_(std::make_unique<Context>()),
      name_(address),
      is_serial_(!address.starts_with("tcp://")),
      buffer_(512) {
  if (is_serial_) {
    context_->modbus = modbus_new_rtu(address.c_str(), static_cast<int>(baud), 'N', 8, 1);
  } else {
    constexpr std::size_t kPrefix = 6;
    const std::size_t colon = address.rfind(':');
    if (colon == std::string::npos || colon <= kPrefix || colon + 1 == address.size()) {
      throw geometry::InputError("'" + address + "' is no address", "Write tcp://HOST:PORT");
    }
    context_->modbus = modbus_new_tcp_pi(address.substr(kPrefix, colon - kPrefix).c_str(),
                                         address.substr(colon + 1).c_str());
  }
  const auto microseconds = reply_time.count();
  const bool is_open = context_->modbus && modbus_set_slave(context_->modbus, unit) == 0 &&
                       modbus_set_response_timeout(
                           context_->modbus, static_cast<std::uint32_t>(microseconds / 1000000),
                           static_cast<std::uint32_t>(microseconds % 1000000)) == 0 &&
                       modbus_connect(context_->modbus) == 0;
  if (is_open) return;
  const int code = errno;
  if (is_serial_ && code == EACCES) throw_no_permission(address);
  throw geometry::InputError("cannot open " + address + ": " + modbus_strerror(code),
                             is_serial_ ? "Check plug and name (ls /dev/serial/by-id)"
                                        : "Check that the gateway is on, its address and its port");
}

ModbusLine::~ModbusLine() = default;

void ModbusLine::fail(const std::string& what) const {
  const int code = errno;
  const bool is_answer_wrong = code == ETIMEDOUT || code >= MODBUS_ENOBASE;
  if (is_answer_wrong) modbus_flush(context_->modbus);
  throw ModbusError(name_ + ": " + what + ": " + modbus_strerror(code), !is_answer_wrong);
}

void ModbusLine::read(std::uint16_t address, std::span<std::uint16_t> values) {
  const int count = static_cast<int>(values.size());
  if (modbus_read_registers(context_->modbus, address, count, values.data()) != count) {
    fail("registers from " + std::to_string(address) + " on cannot be read");
  }
}

void ModbusLine::write(std::uint16_t address, std::span<const std::uint16_t> values) {
  const int count = static_cast<int>(values.size());
  if (modbus_write_registers(context_->modbus, address, count, values.data()) != count) {
    fail("register " + std::to_string(address) + " cannot be written");
  }
}

std::span<const std::uint8_t> ModbusLine::read_bytes(std::chrono::nanoseconds timeout) {
  const IoResult result = read_descriptor(modbus_get_socket(context_->modbus), buffer_, timeout);
  if (result.status == IoStatus::kClosed) throw ModbusError(name_ + ": " + result.problem, true);
  return {buffer_.data(), result.count};
}

void ModbusLine::write_bytes(std::span<const std::uint8_t> bytes) {
  constexpr auto kWriteTime = std::chrono::milliseconds(500);
  const IoResult result = write_descriptor(modbus_get_socket(context_->modbus), bytes, kWriteTime);
  if (result.status != IoStatus::kOk) {
    throw ModbusError(name_ + ": " + result.problem, result.status == IoStatus::kClosed);
  }
}

}  // namespace prehend::drivers::ft300
