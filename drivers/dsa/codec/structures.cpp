#include "drivers/dsa/codec/structures.h"

#include <tuple>

namespace prehend::drivers::dsa {
namespace {

constexpr const char* kStatusWords[kStatusCount] = {"success",
                                                    "not available",
                                                    "no sensor",
                                                    "not initialized",
                                                    "already running",
                                                    "feature not supported",
                                                    "inconsistent data",
                                                    "timeout",
                                                    "read error",
                                                    "write error",
                                                    "insufficient resources",
                                                    "checksum error",
                                                    "not enough parameters",
                                                    "unknown command",
                                                    "format error",
                                                    "access denied",
                                                    "already open",
                                                    "command failed",
                                                    "aborted",
                                                    "invalid handle",
                                                    "device not found",
                                                    "device not opened",
                                                    "I/O error",
                                                    "invalid parameter",
                                                    "index out of bounds",
                                                    "pending",
                                                    "overrun",
                                                    "range error"};

// The fields of each structure in the order of the wire, for both directions.
template <class Info>
auto fields(Info& i) requires requires {
  i.can_baud;
}
{
  return std::tie(i.status, i.serial, i.hardware, i.software, i.status_flags, i.feature_flags,
                  i.sensor_type, i.active_interface, i.can_baud, i.can_id);
}
template <class Info>
auto fields(Info& i) requires requires {
  i.generated_by;
}
{ return std::tie(i.status, i.matrices, i.generated_by, i.hardware, i.serial, i.feature_flags); }
template <class Info>
auto fields(Info& i) requires requires {
  i.texel_width;
}
{
  return std::tie(i.status, i.texel_width, i.texel_height, i.cells_x, i.cells_y, i.uid, i.reserved,
                  i.hardware, i.centre, i.orientation, i.full_scale, i.feature_flags);
}
template <class Info>
auto fields(Info& i) requires requires {
  i.adjust_flags;
}
{ return std::tie(i.status, i.adjust_flags, i.current, i.factory); }
template <class Info>
auto fields(Info& i) requires(requires {
  i.status;
  i.threshold;
}) {
  return std::tie(i.status, i.threshold);
}
template <class Info>
auto fields(Info& i) requires requires {
  i.rate;
}
{ return std::tie(i.flags, i.rate); }
template <class Info>
auto fields(Info& i) requires requires {
  i.sensitivity;
}
{ return std::tie(i.flags, i.matrix, i.sensitivity); }
template <class Info>
auto fields(Info& i) requires(requires {
  i.matrix;
  i.threshold;
}) {
  return std::tie(i.flags, i.matrix, i.threshold);
}

template <class Number>
void put(Payload& payload, Number value) {
  append_little(payload, value);
}
template <class Number, std::size_t kCount>
void put(Payload& payload, const std::array<Number, kCount>& values) {
  for (const Number value : values) append_little(payload, value);
}

template <class Number>
void get(ByteReader& reader, Number& value) {
  value = reader.take<Number>();
}
template <class Number, std::size_t kCount>
void get(ByteReader& reader, std::array<Number, kCount>& values) {
  for (Number& value : values) value = reader.take<Number>();
}

template <class Info>
Payload encode_fields(const Info& info) {
  Payload payload;
  std::apply([&](const auto&... field) { (put(payload, field), ...); }, fields(info));
  return payload;
}

template <class Info>
std::optional<Info> decode_fields(Bytes payload) {
  Info info;
  ByteReader reader(payload);
  std::apply([&](auto&... field) { (get(reader, field), ...); }, fields(info));
  if (!reader.complete()) return std::nullopt;
  return info;
}

}  // namespace

std::string describe_status(std::uint16_t status) {
  const std::string words = status < kStatusCount ? kStatusWords[status] : "unknown status";
  return words + " (" + std::to_string(status) + ")";
}

Payload encode(const ControllerInfo& info) { return encode_fields(info); }
Payload encode(const SensorInfo& info) { return encode_fields(info); }
Payload encode(const MatrixInfo& info) { return encode_fields(info); }
Payload encode(const SensitivityInfo& info) { return encode_fields(info); }
Payload encode(const ThresholdInfo& info) { return encode_fields(info); }
Payload encode(const Acquisition& request) { return encode_fields(request); }
Payload encode(const SetSensitivity& request) { return encode_fields(request); }
Payload encode(const SetThreshold& request) { return encode_fields(request); }

Payload encode_status(std::uint16_t status) {
  Payload payload;
  append_little(payload, status);
  return payload;
}

std::optional<ControllerInfo> decode_controller_info(Bytes payload) {
  constexpr std::size_t kSize = 18, kSizeOfLibrary = 19;
  return decode_fields<ControllerInfo>(payload.size() == kSizeOfLibrary ? payload.first(kSize)
                                                                        : payload);
}
std::optional<SensorInfo> decode_sensor_info(Bytes payload) {
  return decode_fields<SensorInfo>(payload);
}
std::optional<MatrixInfo> decode_matrix_info(Bytes payload) {
  return decode_fields<MatrixInfo>(payload);
}
std::optional<SensitivityInfo> decode_sensitivity_info(Bytes payload) {
  return decode_fields<SensitivityInfo>(payload);
}
std::optional<ThresholdInfo> decode_threshold_info(Bytes payload) {
  if (payload.size() == 2) return ThresholdInfo{*decode_status(payload), 0};
  return decode_fields<ThresholdInfo>(payload);
}
std::optional<Acquisition> decode_acquisition(Bytes payload) {
  return decode_fields<Acquisition>(payload);
}
std::optional<SetSensitivity> decode_set_sensitivity(Bytes payload) {
  return decode_fields<SetSensitivity>(payload);
}
std::optional<SetThreshold> decode_set_threshold(Bytes payload) {
  return decode_fields<SetThreshold>(payload);
}

std::optional<std::uint16_t> decode_status(Bytes payload) {
  if (payload.size() < 2) return std::nullopt;
  return load_little<std::uint16_t>(payload.data());
}

}  // namespace prehend::drivers::dsa
