#include "eval/touch/imprints.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "eval/touch/imprint_trials.h"
#include "eval/touch/pressing.h"

namespace prehend::eval::touch {
namespace {

TEST(Imprints, PerforatedBlocksAreClosedSolids) {
  const Eigen::Vector3d size(0.04, 0.03, 0.036);
  std::vector<Hole> all = holes();
  all.insert(all.end(), holes_to_choose_on().begin(), holes_to_choose_on().end());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Hole &hole = all[i], &other = all[(i + 3) % all.size()];
    const geometry::TriangleMesh mesh =
        perforated_block(size, {&hole, {0.002, 0.001}}, {&other, {-0.003, 0}});
    EXPECT_TRUE(geometry::find_defects(mesh).watertight())
        << hole.name << ": " << geometry::find_defects(mesh).to_string();
    double area = 0;  // of both holes
    for (double x = -0.02; x < 0.02; x += 1e-4) {
      for (double y = -0.02; y < 0.02; y += 1e-4) {
        area += 1e-8 * (hole.contains({x, y}) + other.contains({x, y}));
      }
    }
    const double volume = size.prod() - 0.008 * area;
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, volume, 0.01 * volume) << hole.name;
  }
}

// What is reported must not be what was chosen on: other shapes, other pads, other presses.
TEST(Imprints, ChoicesAndReportsShareNothing) {
  constexpr double kCell = 1e-3;  // m
  for (const Hole& reported : holes()) {
    for (const Hole& choosing : holes_to_choose_on()) {
      EXPECT_NE(reported.name, choosing.name);
      int differ = 0;
      for (double x = -0.02; x < 0.02; x += kCell) {
        for (double y = -0.02; y < 0.02; y += kCell) {
          differ += reported.contains({x, y}) != choosing.contains({x, y});
        }
      }
      EXPECT_GT(differ, 20) << "mm^2: " << reported.name << ", " << choosing.name;
    }
  }
  for (const std::uint32_t reported : kReportedSeeds) {
    for (const std::uint32_t choosing : kChoosingSeeds) {
      EXPECT_GE(std::max(reported, choosing) - std::min(reported, choosing), 2u)
          << "a pair of pads has two seeds";
    }
  }
}

// A few presses of a few shapes, from block to answer; eval_shape_recognition does all.
TEST(Imprints, RealisticPadsTellShapesAndRefuseOthers) {
  const std::vector<Hole> few{holes()[0], holes()[1], holes()[4], holes()[6]};
  const BlockPresses presses = press_blocks(few, true, kReportedSeeds[0], 8);
  EXPECT_GT(presses.least_difference, 1) << "the two sides' frames, over noise";
  prehend::touch::ImprintMemory memory;
  for (int k = 0; k < 3; ++k) memory.teach(few[k].name, presses.of.at(few[k].name).taught);
  int right = 0;
  for (const auto& [shown, answer] : ask_all(memory, fits_of(presses, memory), 4)) {
    right += answer.name == (shown == few[3].name ? "" : shown);
  }
  EXPECT_GE(right, 7) << "of 8";
}

TEST(Imprints, ThePadsFeelTheHoles) {
  Presser presser({});
  const geometry::TriangleMesh mesh =
      perforated_block({0.08, 0.04, 0.08}, {&holes()[1], {0.001, 0.001}}, {nullptr, {0, 0}});
  const auto pressed =
      presser.press(contact::Shape::mesh(mesh), geometry::RigidTransform::Identity());
  ASSERT_TRUE(pressed);
  // Squares of 16.8 mm: texels whose middle is in it; nothing on the other side.
  int empty = 0, whole = 0;
  for (std::size_t i = 0; i < 84; ++i) {
    const Eigen::Vector3d p = presser.pad().layout.position(i);
    const bool in_hole = holes()[1].contains({p.x() - 0.001, p.y() - 0.001});
    EXPECT_EQ(pressed->frames[0][i] == 0, in_hole) << i;
    empty += pressed->frames[0][i] == 0;
    whole += pressed->frames[1][i] > 0;
  }
  EXPECT_EQ(empty, 25);
  EXPECT_EQ(whole, 84);
  EXPECT_NEAR(pressed->opening, 0.04, 0.001);
  // What is wider than the jaws open is not pressed.
  EXPECT_FALSE(
      presser.press(contact::Shape::box({0.02, 0.08, 0.02}), geometry::RigidTransform::Identity()));
}

}  // namespace
}  // namespace prehend::eval::touch
