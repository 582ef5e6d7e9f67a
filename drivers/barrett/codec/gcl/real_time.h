#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/barrett/codec/axes.h"
#include "drivers/wire/encoding/byte_order.h"

/// RealTime mode: after `LOOP` the host sends control blocks, each of which is answered at once by
/// a feedback block. What is in them follows from properties (MAN43 and MAN44, chapter 6; BHAPI).
namespace prehend::drivers::barrett::gcl {

/// What its blocks depend on: 4.4 has LCT, LFBP and LFAIN, and one byte of LFT where 4.3 has two.
enum class Firmware { k4_3, k4_4 };
/// Of the text of VERS, whatever else is in it: its first "4.3" or "4.4".
std::optional<Firmware> firmware_of(std::string_view version);

/// The first byte of a control block (BHAPI, gripper::barrett).
enum class Header : std::uint8_t {
  kControl = 'C',         // data; answered by a feedback block
  kControlOnly = 'c',     // data; answered by * alone
  kFeedback = 'A',        // no data; answered by a feedback block
  kAcknowledgement = 'a'  // no data; answered by * alone
};

/// A motor's part in the blocks: the flags of its properties.
struct MotorLayout {
  bool loops = false;                                               // named in LOOP
  bool velocity = true, gain = true, torque = false;                // LCV, LCPG, LCT
  bool speed = true, strain = true, position = true, delta = true;  // LFV, LFS, LFAP, LFDP
  bool breakaway = false, analog = false;                           // LFBP, LFAIN
  int velocity_coefficient = 1;                                     // LCVC
  int speed_coefficient = 1;                                        // LFVC
  int delta_coefficient = 1;                                        // LFDPC

  friend bool operator==(const MotorLayout&, const MotorLayout&) = default;
};

struct Layout {
  std::array<MotorLayout, kAxes> motors{};
  bool temperature = false;  // LFT
  Firmware firmware = Firmware::k4_3;

  /// Bytes behind the header, and of a feedback block with its *.
  std::size_t control_size() const;
  std::size_t feedback_size() const;
  /// Why a hand would not take it; "" when it does.
  std::string problem() const;
  friend bool operator==(const Layout&, const Layout&) = default;
};

struct MotorControl {
  int velocity = 0;  // LCV: -127 to 127, in LCVC counts per 10 ms
  int gain = 0;      // LCPG: 0 to 255
  int torque = 0;    // LCT: added to the position as its reference, counts
};
using Controls = std::array<MotorControl, kAxes>;

struct MotorFeedback {
  int speed = 0;      // LFV: counts per 10 ms, over LFVC
  int strain = 0;     // LFS: 0 to 255, 255: there is no gauge
  int position = 0;   // LFAP, counts; the manuals say unsigned, but none is beyond 18000
  int delta = 0;      // LFDP: counts since the last one, over LFDPC
  int breakaway = 0;  // LFBP, counts
  int analog = 0;     // LFAIN
};
struct Feedback {
  std::array<MotorFeedback, kAxes> motors{};
  int temperature = 0;  // LFT: 4.3 0.1 degree Celsius, 4.4 degree Celsius; not confirmed
};

/// Values beyond their range are cut to it.
std::vector<std::uint8_t> encode_control(Header header, const Controls& controls,
                                         const Layout& layout);
/// Of the data behind a header; nothing when their size is another.
std::optional<Controls> decode_control(Bytes data, const Layout& layout);

std::vector<std::uint8_t> encode(const Feedback& feedback, const Layout& layout);
/// Of a whole block with its *; nothing when it is none.
std::optional<Feedback> decode_feedback(Bytes block, const Layout& layout);

/// Of one LFDP: what of `way` [counts] fits into a byte, over `coefficient`.
int delta_of(int way, int coefficient);

}  // namespace prehend::drivers::barrett::gcl
