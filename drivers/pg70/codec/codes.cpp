#include "drivers/pg70/codec/codes.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace prehend::drivers::pg70 {
namespace {

constexpr std::array kCommands{
    CodeText{0x80, "GET CONFIG", "asks for one configuration parameter, or for the device's facts"},
    CodeText{0x81, "SET CONFIG", "sets one configuration parameter"},
    CodeText{0x82, "GET CONFIG EXT", "asks for an extended configuration parameter"},
    CodeText{0x83, "SET CONFIG EXT", "sets an extended configuration parameter"},
    CodeText{0x84, "FRAG START", "first fragment of a long message"},
    CodeText{0x85, "FRAG MIDDLE", "middle fragment of a long message"},
    CodeText{0x86, "FRAG END", "last fragment of a long message"},
    CodeText{0x87, "FRAG ACK", "acknowledges a fragment, on Profibus only"},
    CodeText{0x88, "CMD ERROR", "fault: the motor is off until the error is acknowledged"},
    CodeText{0x89, "CMD WARNING", "an acknowledged error whose cause persists"},
    CodeText{0x8A, "CMD INFO", "information"},
    CodeText{0x8B, "CMD ACK", "acknowledges a fault"},
    CodeText{0x90, "CMD FAST STOP", "shorts the motor and applies the brake; to be acknowledged"},
    CodeText{0x91, "CMD STOP", "brakes to a stand"},
    CodeText{0x92, "CMD REFERENCE", "finds the reference position; the jaws move"},
    CodeText{0x93, "CMD MOVE BLOCKED", "the motion ended before its target"},
    CodeText{0x94, "CMD POS REACHED", "the motion ended at its target"},
    CodeText{0x95, "GET STATE", "asks for position, velocity, current and status"},
    CodeText{0x96, "GET DETAILED ERROR INFO", "asks for the data of the present fault"},
    CodeText{0x97, "CMD REFERENCE HAND", "takes the present position as reference"},
    CodeText{0xA0, "SET TARGET VEL", "sets the speed of motions to come"},
    CodeText{0xA1, "SET TARGET ACC", "sets the acceleration of motions to come"},
    CodeText{0xA2, "SET TARGET JERK", "sets the jerk of motions to come"},
    CodeText{0xA3, "SET TARGET CUR", "sets the current limit of motions to come"},
    CodeText{0xA4, "SET TARGET TIME", "sets the duration of motions to come"},
    CodeText{0xA6, "SET TARGET POS", "sets the target position"},
    CodeText{0xA7, "SET TARGET POS REL", "sets the target position relative to the present one"},
    CodeText{0xB0, "MOVE POS", "moves to a position"},
    CodeText{0xB1, "MOVE POS TIME", "moves to a position in a given time"},
    CodeText{0xB3, "MOVE CUR", "drives with a current"},
    CodeText{0xB5, "MOVE VEL", "moves with a speed"},
    CodeText{0xB7, "MOVE GRIP", "raises the current until it grips"},
    CodeText{0xB8, "MOVE POS REL", "moves by a distance"},
    CodeText{0xB9, "MOVE POS TIME REL", "moves by a distance in a given time"},
    CodeText{0xE0, "CMD REBOOT", "starts the device anew"},
    CodeText{0xE3, "CHANGE USER", "changes the rights of the master"},
    CodeText{0xE4, "CHECK MC PC COMMUNICATION", "tests the way from the module to the master"},
    CodeText{0xE5, "CHECK PC MC COMMUNICATION", "tests the way from the master to the module"},
    CodeText{0xE7, "CMD TOGGLE IMPULSE MESSAGE", "switches spontaneous messages on or off"}};

constexpr std::array kInfos{
    CodeText{0x01, "INFO BOOT", "the device has started"},
    CodeText{0x02, "INFO NO FREE SPACE", "the device has no memory left for this"},
    CodeText{0x03, "INFO NO RIGHTS", "the present user may not do this; change the user"},
    CodeText{0x04, "INFO UNKNOWN COMMAND", "the device does not know this command"},
    CodeText{0x05, "INFO FAILED", "the command could not be carried out"},
    CodeText{0x06, "INFO NOT REFERENCED", "reference the gripper first"},
    CodeText{0x07, "INFO SEARCH SINE VECTOR", "the device looks for the rotor's position; wait"},
    CodeText{0x08, "INFO NO ERROR", "no error is present any more"},
    CodeText{0x09, "INFO COMMUNICATION ERROR", "a message was damaged on its way"},
    CodeText{0x10, "INFO TIMEOUT", "a message came too slowly"},
    CodeText{0x11, "INFO UNKNOWN AXIS INDEX", "the device has no such axis"},
    CodeText{0x16, "INFO WRONG BAUDRATE", "the device does not offer this bit rate"},
    CodeText{0x19, "INFO CHECKSUM", "a message's checksum was wrong"},
    CodeText{0x1B, "INFO VALUE LIMIT MAX", "a value was above what is allowed"},
    CodeText{0x1C, "INFO VALUE LIMIT MIN", "a value was below what is allowed"},
    CodeText{0x1D, "INFO MESSAGE LENGTH", "a message had the wrong length"},
    CodeText{0x1E, "INFO WRONG PARAMETER", "a parameter was wrong or out of range"},
    CodeText{0x1F, "INFO PROGRAM END", "the program stored in the device has ended"},
    CodeText{0x40, "INFO TRIGGER", "a trigger came"},
    CodeText{0x41, "INFO READY", "the device is ready"},
    CodeText{0x42, "INFO GUI CONNECTED", "a configuration program took the device over"},
    CodeText{0x43, "INFO GUI DISCONNECTED", "a configuration program let the device go"},
    CodeText{0x44, "INFO PROGRAM CHANGED", "the program stored in the device was changed"}};

constexpr std::array kErrors{
    CodeText{0x00, "NO ERROR", "no error is present"},
    CodeText{0x70, "ERROR TEMP LOW", "too cold; let it warm up"},
    CodeText{0x71, "ERROR TEMP HIGH", "too hot; let it cool down"},
    CodeText{0x72, "ERROR LOGIC LOW", "logic supply voltage too low; check the supply"},
    CodeText{0x73, "ERROR LOGIC HIGH", "logic supply voltage too high; check the supply"},
    CodeText{0x74, "ERROR MOTOR VOLTAGE LOW",
             "motor supply voltage too low; check supply, fuse, wire"},
    CodeText{0x75, "ERROR MOTOR VOLTAGE HIGH", "motor supply voltage too high; brake more gently"},
    CodeText{0x76, "ERROR CABLE BREAK", "a cable is broken; check the plugs"},
    CodeText{0x78, "ERROR MOTOR TEMP", "motor too hot; let it cool down and use less current"},
    CodeText{0x82, "ERROR OVERSHOOT", "the target was overrun; use a lower speed"},
    CodeText{0xC8, "ERROR WRONG RAMP TYPE", "velocity, acceleration and jerk do not fit together"},
    CodeText{0xD2, "ERROR CONFIG MEMORY", "configuration memory is damaged; Schunk's service"},
    CodeText{0xD3, "ERROR PROGRAM MEMORY", "program memory is damaged; Schunk's service"},
    CodeText{0xD4, "ERROR INVALID PHRASE", "the stored program has an invalid step"},
    CodeText{0xD5, "ERROR SOFT LOW",
             "below the lower soft limit; acknowledge, then move back inside"},
    CodeText{0xD6, "ERROR SOFT HIGH",
             "above the upper soft limit; acknowledge, then move back inside"},
    CodeText{0xD7, "ERROR PRESSURE", "pressure out of range"},
    CodeText{0xD8, "ERROR SERVICE", "the device asks for service"},
    CodeText{0xD9, "ERROR EMERGENCY STOP",
             "fast stop: motor shorted, brake applied; acknowledge it"},
    CodeText{0xDA, "ERROR TOW", "the drive cannot follow its target; look for what jams the jaws"},
    CodeText{0xDB, "ERROR VPC3", "the Profibus chip failed; Schunk's service"},
    CodeText{0xDC, "ERROR FRAGMENTATION", "fragments of a message were lost or out of order"},
    CodeText{0xDD, "ERROR COMMUTATION", "the motor cannot commutate; Schunk's service if it stays"},
    CodeText{0xDE, "ERROR CURRENT", "current too high; look for a jam or a short circuit"},
    CodeText{0xDF, "ERROR I2T", "too much current for too long; let it rest and use less"},
    CodeText{0xE0, "ERROR INITIALIZE", "start-up failed; switch the supply off and on"},
    CodeText{0xE1, "ERROR INTERNAL", "internal failure; switch the supply off and on"},
    CodeText{0xE2, "ERROR HARD LOW", "at the lower end switch; move back by hand or acknowledge"},
    CodeText{0xE3, "ERROR HARD HIGH", "at the upper end switch; move back by hand or acknowledge"},
    CodeText{0xE4, "ERROR TOO FAST", "faster than allowed; use a lower speed"},
    CodeText{0xE5, "ERROR RESOLVER CHECK FAILED", "position sensor failed (code of EGL grippers)"},
    CodeText{0xEB, "ERROR RESOLVER CHECK FAILED", "position sensor failed; check its cable"},
    CodeText{0xEC, "ERROR MATH", "a computation failed in the device; report it to Schunk"}};

constexpr bool is_sorted_by_code(std::span<const CodeText> texts) {
  return std::ranges::is_sorted(texts, {}, &CodeText::code);
}
static_assert(is_sorted_by_code(kCommands) && is_sorted_by_code(kInfos) &&
              is_sorted_by_code(kErrors));

const CodeText* find(std::span<const CodeText> texts, std::uint8_t code) {
  const auto found = std::ranges::lower_bound(texts, code, {}, &CodeText::code);
  return found != texts.end() && found->code == code ? &*found : nullptr;
}

std::string in_hexadecimal(std::uint8_t code) {
  char text[8];
  std::snprintf(text, sizeof text, "0x%02X", code);
  return text;
}

}  // namespace

std::span<const CodeText> command_texts() { return kCommands; }
std::span<const CodeText> info_texts() { return kInfos; }
std::span<const CodeText> error_texts() { return kErrors; }

std::string describe_code(std::uint8_t code) {
  const CodeText* text = find(kErrors, code);
  if (!text) text = find(kInfos, code);
  if (!text) return "unknown code " + in_hexadecimal(code);
  return std::string(text->name) + " (" + in_hexadecimal(code) + "): " + text->words;
}

std::string command_name(std::uint8_t command) {
  const CodeText* text = find(kCommands, command);
  return text ? text->name : "command " + in_hexadecimal(command);
}

}  // namespace prehend::drivers::pg70
