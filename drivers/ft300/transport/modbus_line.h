#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace prehend::drivers::ft300 {

/// A Modbus transaction that failed. `closed`: the line itself is gone.
class ModbusError : public std::runtime_error {
 public:
  ModbusError(const std::string& words, bool is_closed)
      : std::runtime_error(words), closed(is_closed) {}
  bool closed;
};

/// A Modbus master (libmodbus) on one line: RTU on "/dev/...", 8N1, or TCP to a gateway,
/// "tcp://HOST:PORT". For one thread.
class ModbusLine {
 public:
  /// @throws geometry::InputError naming the line and the mend.
  ModbusLine(const std::string& address, unsigned baud, std::uint8_t unit,
             std::chrono::microseconds reply_time);
  ~ModbusLine();
  ModbusLine(const ModbusLine&) = delete;
  ModbusLine& operator=(const ModbusLine&) = delete;

  /// `values.size()` holding registers from `address` on (FC03). @throws ModbusError.
  void read(std::uint16_t address, std::span<std::uint16_t> values);
  /// FC16. @throws ModbusError.
  void write(std::uint16_t address, std::span<const std::uint16_t> values);

  /// Bytes beside Modbus, as the sensor's stream. Empty after `timeout`. @throws ModbusError
  /// closed.
  std::span<const std::uint8_t> read_bytes(std::chrono::nanoseconds timeout);
  void write_bytes(std::span<const std::uint8_t> bytes);

  bool is_serial() const { return is_serial_; }
  const std::string& name() const { return name_; }

 private:
  [[noreturn]] void fail(const std::string& what) const;

  struct Context;
  std::unique_ptr<Context> context_;
  std::string name_;
  bool is_serial_ = true;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace prehend::drivers::ft300
