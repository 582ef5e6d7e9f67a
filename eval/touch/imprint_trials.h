#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "eval/touch/imprints.h"
#include "eval/touch/pressing.h"
#include "prehend/touch/imprint_memory.h"

// Presses of blocks with holes at any turn and place, and what a recogniser says to them.
namespace prehend::eval::touch {

inline constexpr int kTaughtPresses = 12;  // of each shape

/// Of pads, turns and places (see press_blocks) on which choices are made, and of those reported.
inline constexpr std::array<std::uint32_t, 3> kChoosingSeeds{101, 201, 301};
inline constexpr std::array<std::uint32_t, 3> kReportedSeeds{1, 11, 21};

/// A hole's presses: those that teach it, and those that are asked about.
struct HolePresses {
  std::vector<prehend::touch::Imprint> taught, asked;
  std::vector<double> first_frame;  // counts, of the first press
};

struct BlockPresses {
  std::map<std::string, HolePresses> of;  // by the hole's name
  /// Of two sides' frames of one press, at the same places of the block: root mean square of their
  /// difference over that of a side's frames of one another.
  double least_difference = 0;
};

/// Blocks of 80 x 40 x 80 mm with holes off-centre in two sides, the first with the first two of
/// `holes` and so on, pressed by 20 N at any turn and up to `largest_shift` off the pads' middle.
/// Pads, turns and places are drawn by `seed`; pads of other seeds are other pads.
/// @throws std::invalid_argument for an odd number of holes.
BlockPresses press_blocks(const std::vector<Hole>& holes, bool realistic, std::uint32_t seed,
                          int asked);
inline const Eigen::Vector2d kLargestShift(0.003, 0.012);  // m, across and along the pads

/// How each press that is asked about fits each shape that was taught.
using FitsOfHoles = std::map<std::string, std::vector<prehend::touch::ImprintMemory::Fits>>;
FitsOfHoles fits_of(const BlockPresses& presses, const prehend::touch::ImprintMemory& memory);

struct AnsweredQuestion {
  std::string shown;
  prehend::touch::Recognised answer;
};
/// Asks about `together` presses of a hole at a time; no press is in two questions.
std::vector<AnsweredQuestion> ask_all(const prehend::touch::ImprintMemory& memory,
                                      const FitsOfHoles& fits, int together);

}  // namespace prehend::eval::touch
