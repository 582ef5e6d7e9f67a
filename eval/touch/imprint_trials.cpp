#include "eval/touch/imprint_trials.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <Eigen/Geometry>

namespace prehend::eval::touch {
namespace {

const Eigen::Vector3d kBlock(0.08, 0.04, 0.08);  // m
const std::array<Eigen::Vector2d, 2> kCenters{Eigen::Vector2d(0.0025, -0.0015),
                                              Eigen::Vector2d(-0.002, 0.003)};  // m, of the holes

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// How the two sides' frames differ at the same places of the block, over what one side's frames
// differ from one another. The pads face one another: their columns run against each other.
double difference_over_noise(const Pressed& pressed, int columns) {
  std::vector<double> sides, noise;
  for (std::size_t i = 0; i < pressed.frames[0].size(); ++i) {
    const std::size_t row = i / columns, column = i % columns;
    const std::size_t facing = row * columns + (columns - 1 - column);
    sides.push_back(1.0 * pressed.frames[0][i] - pressed.frames[1][facing]);
    for (const int side : {0, 1}) {
      noise.push_back(1.0 * pressed.frames[side][i] - pressed.again[side][i]);
    }
  }
  constexpr double kRounding = 0.41;  // counts, of the difference of two rounded values
  return root_mean_square(sides) / std::max(kRounding, root_mean_square(noise));
}

geometry::RigidTransform random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi), unit(-1, 1);
  geometry::RigidTransform X_GB = geometry::RigidTransform::Identity();
  X_GB.linear() = Eigen::AngleAxisd(turn(random), Eigen::Vector3d::UnitY()).matrix();
  X_GB.translation().x() = kLargestShift.x() * unit(random);
  X_GB.translation().z() = kLargestShift.y() * unit(random);
  return X_GB;
}

void add_press(const Presser& presser, const std::vector<std::uint16_t>& frame,
               HolePresses* presses) {
  const std::vector<double> counts(frame.begin(), frame.end());
  const auto imprint = imprint_of(presser.pad(), felt_texels(presser.pad(), counts));
  if (!imprint) throw std::runtime_error("a block left no imprint");
  if (presses->first_frame.empty()) presses->first_frame = counts;
  const bool teaches = static_cast<int>(presses->taught.size()) < kTaughtPresses;
  (teaches ? presses->taught : presses->asked).push_back(*imprint);
}

}  // namespace

BlockPresses press_blocks(const std::vector<Hole>& holes, bool realistic, std::uint32_t seed,
                          int asked) {
  if (holes.size() % 2 != 0) throw std::invalid_argument("press_blocks: a block has two holes");
  Presser presser({.realistic = realistic, .seed = seed});
  std::mt19937 random(seed);
  BlockPresses all{{}, INFINITY};
  for (std::size_t k = 0; k < holes.size(); k += 2) {
    const contact::Shape block = contact::Shape::mesh(
        perforated_block(kBlock, {&holes[k], kCenters[0]}, {&holes[k + 1], kCenters[1]}));
    for (int i = 0; i < kTaughtPresses + asked; ++i) {
      const auto pressed = presser.press(block, random_pose(random));
      if (!pressed) throw std::runtime_error("a block was not pressed");
      all.least_difference = std::min(
          all.least_difference, difference_over_noise(*pressed, presser.pad().layout.columns()));
      for (const std::size_t side : {0, 1}) {
        add_press(presser, pressed->frames[side], &all.of[holes[k + side].name]);
      }
    }
  }
  return all;
}

FitsOfHoles fits_of(const BlockPresses& presses, const prehend::touch::ImprintMemory& memory) {
  FitsOfHoles fits;
  for (const auto& [name, hole] : presses.of) {
    for (const auto& press : hole.asked) fits[name].push_back(memory.fits(press));
  }
  return fits;
}

std::vector<AnsweredQuestion> ask_all(const prehend::touch::ImprintMemory& memory,
                                      const FitsOfHoles& fits, int together) {
  std::vector<AnsweredQuestion> answers;
  for (const auto& [name, presses] : fits) {
    for (std::size_t i = 0; i + together <= presses.size(); i += together) {
      const auto begin = presses.begin() + static_cast<std::ptrdiff_t>(i);
      answers.push_back({name, memory.judge({begin, begin + together})});
    }
  }
  return answers;
}

}  // namespace prehend::eval::touch
