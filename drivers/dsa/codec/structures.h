#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers::dsa {

// Payloads of the DSACON32-m, packed and little-endian (SDHLibrary-CPP, sdh/dsa.h). Each has
// `encode` and `decode_...`; decoding gives nothing when the size does not fit.

/// What the controller answers with (u16). 0 is success.
enum class Status : std::uint16_t {
  kSuccess = 0,
  kNotAvailable,
  kNoSensor,
  kNotInitialized,
  kAlreadyRunning,
  kFeatureNotSupported,
  kInconsistentData,
  kTimeout,
  kReadError,
  kWriteError,
  kInsufficientResources,
  kChecksumError,
  kNotEnoughParameters,
  kUnknownCommand,
  kFormatError,
  kAccessDenied,
  kAlreadyOpen,
  kCommandFailed,
  kAborted,
  kInvalidHandle,
  kDeviceNotFound,
  kDeviceNotOpened,
  kIoError,
  kInvalidParameter,
  kIndexOutOfBounds,
  kPending,
  kOverrun,
  kRangeError,
};
inline constexpr std::uint16_t kStatusCount = 28;
/// "checksum error (11)"; "unknown status (77)".
std::string describe_status(std::uint16_t status);

/// 0x01. The controller sends 18 bytes although the library's structure has 19: the CAN id is one
/// byte on the wire. 19 are decoded, too. The meaning of the flag bits is not known.
struct ControllerInfo {
  std::uint16_t status = 0;
  std::uint32_t serial = 0;
  std::uint8_t hardware = 0;
  std::uint16_t software = 0;  // firmware, e.g. 300
  std::uint8_t status_flags = 0;
  std::uint8_t feature_flags = 0;
  std::uint8_t sensor_type = 0;
  std::uint8_t active_interface = 0;
  std::uint32_t can_baud = 0;
  std::uint8_t can_id = 0;
  friend bool operator==(const ControllerInfo&, const ControllerInfo&) = default;
};

/// 0x02, 12 bytes.
struct SensorInfo {
  std::uint16_t status = 0;
  std::uint16_t matrices = 0;
  std::uint16_t generated_by = 0;
  std::uint8_t hardware = 0;
  std::uint32_t serial = 0;
  std::uint8_t feature_flags = 0;
  friend bool operator==(const SensorInfo&, const SensorInfo&) = default;
};

/// 0x0B, 52 bytes. Units of centre, orientation and full scale are not known.
struct MatrixInfo {
  std::uint16_t status = 0;
  float texel_width = 0;   // mm
  float texel_height = 0;  // mm
  std::uint16_t cells_x = 0;
  std::uint16_t cells_y = 0;
  std::array<std::uint8_t, 6> uid{};
  std::array<std::uint8_t, 2> reserved{};
  std::uint8_t hardware = 0;
  std::array<float, 3> centre{};
  std::array<float, 3> orientation{};
  float full_scale = 0;
  std::uint8_t feature_flags = 0;
  friend bool operator==(const MatrixInfo&, const MatrixInfo&) = default;
};

/// 0x12, 11 bytes.
struct SensitivityInfo {
  std::uint16_t status = 0;
  std::uint8_t adjust_flags = 0;  // bit 1: the user may change it
  float current = 0;              // 0..1
  float factory = 0;
  friend bool operator==(const SensitivityInfo&, const SensitivityInfo&) = default;
};

/// Answer to 0x14. Firmware from 268 on.
struct ThresholdInfo {
  std::uint16_t status = 0;
  std::uint16_t threshold = 0;  // counts, 0..4095
  friend bool operator==(const ThresholdInfo&, const ThresholdInfo&) = default;
};

/// 0x03. Flags: bit 7 acquire (clear: stop), bit 0 run-length coded. Rate 0 with acquire is a
/// single frame (firmware up to 288 except 269 streams on nevertheless); any other rate streams as
/// fast as the controller can, whatever the number is.
struct Acquisition {
  static constexpr std::uint8_t kAcquire = 0x80, kRunLength = 0x01;
  std::uint8_t flags = 0;
  std::uint16_t rate = 0;  // frames/s
  bool acquires() const { return flags & kAcquire; }
  bool run_length() const { return flags & kRunLength; }
  friend bool operator==(const Acquisition&, const Acquisition&) = default;
};

/// Flags of 0x0F and 0x13. With kPersistent the controller does not answer (a fault of the real
/// firmware).
struct AdjustFlags {
  static constexpr std::uint8_t kFactory = 0x01, kAllMatrices = 0x02, kPersistent = 0x80;
};
struct SetSensitivity {
  std::uint8_t flags = 0;
  std::uint8_t matrix = 0;
  float sensitivity = 0;  // 0..1
  friend bool operator==(const SetSensitivity&, const SetSensitivity&) = default;
};
struct SetThreshold {
  std::uint8_t flags = 0;
  std::uint8_t matrix = 0;
  std::uint16_t threshold = 0;  // counts, 0..4095
  friend bool operator==(const SetThreshold&, const SetThreshold&) = default;
};

using Payload = std::vector<std::uint8_t>;
Payload encode(const ControllerInfo& info);
Payload encode(const SensorInfo& info);
Payload encode(const MatrixInfo& info);
Payload encode(const SensitivityInfo& info);
Payload encode(const ThresholdInfo& info);
Payload encode(const Acquisition& request);
Payload encode(const SetSensitivity& request);
Payload encode(const SetThreshold& request);
Payload encode_status(std::uint16_t status);

std::optional<ControllerInfo> decode_controller_info(Bytes payload);
std::optional<SensorInfo> decode_sensor_info(Bytes payload);
std::optional<MatrixInfo> decode_matrix_info(Bytes payload);
std::optional<SensitivityInfo> decode_sensitivity_info(Bytes payload);
/// A refusal may be the status alone (2 bytes): the threshold is 0 then.
std::optional<ThresholdInfo> decode_threshold_info(Bytes payload);
std::optional<Acquisition> decode_acquisition(Bytes payload);
std::optional<SetSensitivity> decode_set_sensitivity(Bytes payload);
std::optional<SetThreshold> decode_set_threshold(Bytes payload);
/// The status that every answer begins with; nothing when there are fewer than 2 bytes.
std::optional<std::uint16_t> decode_status(Bytes payload);

}  // namespace prehend::drivers::dsa
