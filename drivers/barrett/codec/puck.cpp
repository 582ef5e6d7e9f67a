#include "drivers/barrett/codec/puck.h"

#include <algorithm>

namespace prehend::drivers::barrett {
namespace {

struct Named {
  Property property;
  const char* name;
};
constexpr Named kNames[] = {
    {Property::kVersion, "VERS"},
    {Property::kRole, "ROLE"},
    {Property::kSerial, "SN"},
    {Property::kError, "ERROR"},
    {Property::kStatus, "STAT"},
    {Property::kMode, "MODE"},
    {Property::kTemperature, "TEMP"},
    {Property::kMostTemperature, "OTEMP"},
    {Property::kThermistor, "THERM"},
    {Property::kStrain, "SG"},
    {Property::kCommand, "CMD"},
    {Property::kTorque, "T"},
    {Property::kMostTorque, "MT"},
    {Property::kVelocity, "V"},
    {Property::kMostVelocity, "MV"},
    {Property::kPosition, "P"},
    {Property::kDefaultPosition, "DP"},
    {Property::kEnd, "E"},
    {Property::kMove, "M"},
    {Property::kUptime, "UPSECS"},
    {Property::kInitialVelocity, "IVEL"},
    {Property::kHold, "HOLD"},
    {Property::kStallTime, "TSTOP"},
    {Property::kAcceleration, "ACCEL"},
    {Property::kJointPosition, "JP"},
    {Property::kTactile, "TACT"},
    {Property::kTactileId, "TACTID"},
};

}  // namespace

bool is_wide(std::uint8_t property) {
  // libbarrett, puck.cpp, and pyHand agree on these.
  constexpr std::uint8_t kWide[] = {48, 50, 52, 54, 56, 58, 66, 68, 74, 88, 96, 98};
  return std::ranges::find(kWide, property) != std::end(kWide);
}

std::uint16_t reply_identifier(std::size_t axis, Group group) {
  return static_cast<std::uint16_t>(kToGroup | (kFirstPuck + axis) << kSenderShift |
                                    static_cast<unsigned>(group));
}

std::uint16_t request_identifier(std::size_t axis) {
  return static_cast<std::uint16_t>(kHost << kSenderShift | (kFirstPuck + axis));
}

const char* to_string(Property property) {
  const auto* found = std::ranges::find(kNames, property, &Named::property);
  return found == std::end(kNames) ? nullptr : found->name;
}

std::optional<Property> property_named(std::string_view name) {
  for (const Named& one : kNames) {
    if (name == one.name) return one.property;
  }
  return std::nullopt;
}

}  // namespace prehend::drivers::barrett
