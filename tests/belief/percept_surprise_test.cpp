#include "prehend/belief/percept_surprise.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/belief/percept_forecast.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/whole_file.h"
#include "prehend/planning/hand_act.h"
#include "prehend/simulation/shapes.h"

namespace prehend::belief {
namespace {

using geometry::RigidTransform;
using testing::HasSubstr;

const robot::HandModel& sdh() {
  static const robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  return hand;
}

// From above, fingers 1 and 2 against each other.
planning::GraspToFeel pinch() {
  planning::GraspToFeel grasp;
  grasp.preshape = "pinch";
  grasp.X_WG.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  grasp.X_WG.translation() = Eigen::Vector3d(0, 0, 0.09);
  const robot::Preshape& shape = sdh().preshape(grasp.preshape);
  grasp.open = shape.open;
  grasp.closed = shape.open;
  for (int i = 0; i < sdh().size(); ++i) {
    grasp.closed[i] += 0.3 * shape.closing[static_cast<std::size_t>(i)].rate;
  }
  return grasp;
}

planning::ObjectToFeel box(double width, const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
  RigidTransform X = RigidTransform::Identity();
  X.translation() = at;
  return {geometry::transformed(simulation::make_standing_box({width, width, 0.14}), X), {}, 0.3};
}

// What a box of 60 mm gives, by one act for all tests; with places, and without.
const PerceptForecast& predicted() {
  static const PerceptForecast percepts = predict_percepts(sdh(), pinch(), {{"box", box(0.06), 1}});
  return percepts;
}
const Percepts& exact() { return predicted().possible.front().percepts; }

PerceptSurprise surprise(const Percepts& perceived) {
  return percept_surprise(predicted(), perceived, SurpriseModel::unfitted());
}

PerceivedPad& touching_pad(Percepts& percepts, int index = 0) {
  for (PerceivedPad& pad : percepts.pads) {
    if (pad.at[kClosed].force > 1 && index-- == 0) return pad;
  }
  throw std::runtime_error("no pad touches");
}

double bits_of(const PerceptSurprise& surprise, const std::string& sense) {
  for (const SenseSurprise& one : surprise.senses) {
    if (one.sense == sense) return one.bits;
  }
  throw std::runtime_error("nothing of " + sense);
}

// Force, area and centre of a pad again, from its texels.
void measure(const robot::HandPad& pad, PadImage* image) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  image->force = image->area = 0;
  for (std::size_t i = 0; i < image->texels.size(); ++i) {
    image->force += image->texels[i];
    if (image->texels[i] > 0) image->area += pad.layout->area(i);
    sum += image->texels[i] * pad.layout->position(i);
  }
  image->center_P = image->force > 0 ? Eigen::Vector3d(sum / image->force) : sum;
}

TEST(PredictPercepts, AreOfEachShapeAtFivePlacesAndWeighOne) {
  EXPECT_EQ(predicted().possible.size(), 5u);
  EXPECT_THAT(predicted().problems, testing::IsEmpty());
  double sum = 0;
  for (const PossiblePercepts& one : predicted().possible) sum += one.weight;
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_NEAR(*exact().weight, 0.3 * 9.81, 0.15) << "what hangs in the hand weighs what it weighs";
  const Percepts& percepts = exact();
  ASSERT_EQ(percepts.pads.size(), sdh().pads.size());
  double force = 0;
  for (const double texel : percepts.pads.front().at[kClosed].texels) force += texel;
  EXPECT_DOUBLE_EQ(force, percepts.pads.front().at[kClosed].force);
}

TEST(PredictPercepts, TheSameArgumentsGiveTheSameBits) {
  const PerceptForecast again = predict_percepts(sdh(), pinch(), {{"box", box(0.06), 1}});
  const SurpriseModel model = SurpriseModel::unfitted();
  EXPECT_EQ(percept_surprise(again, exact(), model).bits, surprise(exact()).bits);
}

TEST(PredictPercepts, AShapeThatDoesNotStandIsLeftOutAndSaid) {
  RigidTransform leaning = RigidTransform::Identity();
  leaning.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()).toRotationMatrix();
  leaning.translation().z() = 0.05;
  planning::ObjectToFeel falls = box(0.03);
  falls.mesh_W = geometry::transformed(falls.mesh_W, leaning);
  PerceptOptions options;
  options.place = 0;
  const PerceptForecast one =
      predict_percepts(sdh(), pinch(), {{"falls", falls, 2}, {"box", box(0.06), 1}}, options);
  ASSERT_EQ(one.possible.size(), 1u);
  EXPECT_EQ(one.possible.front().shape, "box");
  EXPECT_DOUBLE_EQ(one.possible.front().weight, 1);
  ASSERT_EQ(one.problems.size(), 1u);
  EXPECT_THAT(one.problems.front(), HasSubstr("falls"));
  EXPECT_THROW(predict_percepts(sdh(), pinch(), {{"box", box(0.06), 0}}), std::invalid_argument);
  EXPECT_THROW(predict_percepts(sdh(), pinch(), {{"box", box(0.06), std::nan("")}}),
               std::invalid_argument);
}

TEST(PerceptSurprise, WhatIsPredictedSurprisesLessThanWhatIsDisplaced) {
  const double least = surprise(exact()).bits;
  EXPECT_LT(least, 0) << "better than expected";
  Percepts displaced = exact();
  double before = least;
  for (int step = 1; step <= 4; ++step) {
    touching_pad(displaced).at[kClosed].center_P.x() += 0.004;
    const double bits = surprise(displaced).bits;
    EXPECT_GT(bits, before) << step;
    before = bits;
  }
  for (PerceivedMotor& motor : displaced.motors) *motor.at[kClosed] += 0.1;
  EXPECT_GT(surprise(displaced).bits, before);
}

TEST(PerceptSurprise, AnObjectThatIsNotThereOrAnotherOneSurprises) {
  ActOptions act;
  const PerceptSurprise absent =
      surprise(simulate_act(sdh(), pinch(), box(0.06, {0.5, 0, 0}), act).percepts);
  EXPECT_TRUE(absent.alarm) << absent.to_string();
  EXPECT_GT(bits_of(absent, "tactile"), 10);
  EXPECT_GT(bits_of(absent, "weight"), 8);
  const PerceptSurprise thin = surprise(simulate_act(sdh(), pinch(), box(0.04), act).percepts);
  EXPECT_GT(bits_of(thin, "joints"), 10) << thin.to_string();
  EXPECT_LT(bits_of(thin, "joints"), bits_of(absent, "joints"));
}

// What is off on one side only is not what is off on the other.
TEST(PerceptSurprise, LeftAndRightSwappedSurprise) {
  planning::ObjectToFeel aside = box(0.06, {0, 0.012, 0});
  PerceptOptions options;
  const PerceptForecast here = predict_percepts(sdh(), pinch(), {{"aside", aside, 1}}, options);
  const Percepts as_predicted = here.possible.front().percepts;
  Percepts swapped = as_predicted;
  PerceivedPad& one = touching_pad(swapped, 0);
  PerceivedPad& two = touching_pad(swapped, 1);
  std::swap(one.at, two.at);
  std::swap(one.touched_at, two.touched_at);
  const SurpriseModel model = SurpriseModel::unfitted();
  const double right = percept_surprise(here, as_predicted, model).bits;
  EXPECT_GT(percept_surprise(here, swapped, model).bits, right + 10);
}

TEST(PerceptSurprise, WhatThereIsNoSensorForCountsNowhere) {
  Percepts blind = exact();
  for (PerceivedPad& pad : blind.pads) pad.at = {};
  for (PerceivedPad& pad : blind.pads) pad.touched_at.reset();
  blind.closing.reset();
  blind.wrist = {};
  blind.weight.reset();
  const PerceptSurprise felt = surprise(blind);
  ASSERT_EQ(felt.senses.size(), 2u);
  EXPECT_EQ(felt.senses[0].sense, "joints");
  EXPECT_EQ(felt.senses[0].bits, bits_of(surprise(exact()), "joints"));
  EXPECT_EQ(felt.senses[1].sense, "time");
  for (PerceivedMotor& motor : blind.motors) motor = {motor.name, {}, {}};
  const PerceptSurprise nothing = surprise(blind);
  EXPECT_EQ(nothing.bits, 0);
  EXPECT_FALSE(nothing.alarm);
  EXPECT_THAT(nothing.senses, testing::IsEmpty());
}

TEST(PerceptSurprise, ADeadRowOrAPadThatShowsTooMuchIsNoAlarm) {
  Percepts dead = exact();
  const PerceivedPad& touched = touching_pad(dead);
  const auto at = static_cast<std::size_t>(&touched - dead.pads.data());
  const auto columns = static_cast<std::size_t>(sdh().pads[at].model.columns);
  for (PadImage& image : dead.pads[at].at) {
    for (std::size_t i = 0; i < columns; ++i) image.texels[3 * columns + i] = 0;
    measure(sdh().pads[at], &image);
  }
  EXPECT_FALSE(surprise(dead).alarm) << surprise(dead).to_string();
  Percepts biased = exact();
  for (PadImage& image : touching_pad(biased).at) {
    for (double& texel : image.texels) texel *= 1.2;
    image.force *= 1.2;
  }
  EXPECT_FALSE(surprise(biased).alarm) << surprise(biased).to_string();
}

TEST(PerceptSurprise, WhatIsNotFiniteIsRefusedByName) {
  Percepts bad = exact();
  bad.pads[1].at[kLifted].texels[2] = std::nan("");
  try {
    surprise(bad);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr(bad.pads[1].name));
    EXPECT_THAT(error.what(), HasSubstr("lifted: texel 2"));
  }
  bad = exact();
  bad.motors[0].at[kClosed] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(surprise(bad), std::invalid_argument);
  bad = exact();
  bad.pads.pop_back();
  EXPECT_THROW(surprise(bad), std::invalid_argument) << "another hand";
  EXPECT_THROW(percept_surprise({}, exact(), SurpriseModel::unfitted()), std::invalid_argument);
}

// A camera looks at what was lifted from the side.
TEST(PerceptSurprise, WhatLooksOtherwiseInTheHandSurprises) {
  PerceptOptions options;
  ViewAfterLift& after = options.view.emplace();
  after.camera = {640, 480, 525, 525, 319.5, 239.5};
  after.X_WC = geometry::look_at({0.6, 0, 0.3}, {0, 0, 0.12});
  after.X_WH = planning::hand_root(sdh(), pinch());
  after.X_WH.translation().z() += options.act.lift_height;
  const PerceptForecast foretold =
      predict_percepts(sdh(), pinch(), {{"box", box(0.06), 1}}, options);
  const Percepts as_foretold = foretold.possible.front().percepts;
  ASSERT_TRUE(as_foretold.view.has_value());
  EXPECT_GT(as_foretold.view->area, 1e-3);
  const SurpriseModel model = SurpriseModel::unfitted();
  const double least = bits_of(percept_surprise(foretold, as_foretold, model), "view");
  EXPECT_LT(least, 0);
  double before = least;
  Percepts beside = as_foretold;
  for (int step = 1; step <= 4; ++step) {
    beside.view->center_C.x() += 0.004;
    const double bits = bits_of(percept_surprise(foretold, beside, model), "view");
    EXPECT_GT(bits, before) << step;
    before = bits;
  }
  Percepts gone = as_foretold;
  gone.view->area = 0;
  EXPECT_GT(bits_of(percept_surprise(foretold, gone, model), "view"), before);
  Percepts blind = as_foretold;
  blind.view.reset();
  EXPECT_EQ(percept_surprise(foretold, blind, model).senses.back().sense, "weight");
  blind = as_foretold;
  blind.view->center_C.y() = std::nan("");
  EXPECT_THROW(percept_surprise(foretold, blind, model), std::invalid_argument);
}

// The expectation of the bits of what is as predicted, with noise of the model's own, is 0.
TEST(PerceptSurprise, AsExpectedIsNoBits) {
  PerceptForecast one;
  one.possible = {{"box", 0, 0, 1, exact()}};
  const SurpriseModel model = SurpriseModel::unfitted();
  std::mt19937 random(1);
  std::student_t_distribution<double> noise(4);
  double sum = 0;
  constexpr int kDraws = 1000;
  for (int i = 0; i < kDraws; ++i) {
    Percepts drawn = exact();
    for (PerceivedMotor& motor : drawn.motors) {
      *motor.at[kClosed] += model.scales.at("joint closed") * noise(random);
      *motor.at[kLifted] += model.scales.at("joint lifted") * noise(random);
    }
    sum += bits_of(percept_surprise(one, drawn, model), "joints");
  }
  EXPECT_NEAR(sum / kDraws, 0, 0.6);  // 14 numbers of 1.4 bits each: 0.17 standard
}

TEST(SurpriseModel, IsFittedToTheShareOfRightActsThatAreAlarms) {
  PerceptForecast one;
  one.possible = {{"box", 0, 0, 1, exact()}};
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1);
  std::vector<Percepts> acts(100, exact());
  for (std::size_t i = 0; i < acts.size(); ++i) {
    const double wild = i < 10 ? 40 : 1;
    for (PerceivedMotor& motor : acts[i].motors) {
      *motor.at[kClosed] += 0.005 * (i % 2 ? wild : 1) * noise(random);
    }
    *acts[i].weight += 0.1 * (i % 2 ? 1 : wild) * noise(random);
  }
  std::vector<KnownPercepts> right;
  for (const Percepts& act : acts) right.push_back({&one, &act});
  const double rate = 0.04;
  const SurpriseModel model = fit_surprise(right, rate);
  int alarms = 0;
  std::map<std::string, int> standing_out;
  for (const Percepts& act : acts) {
    const PerceptSurprise bits = percept_surprise(one, act, model);
    alarms += bits.alarm;
    bool told = bits.bits > bits.threshold;
    for (const SenseSurprise& sense : bits.senses) {
      told = told || (sense.alarm && sense.sense == "time");
    }
    EXPECT_EQ(bits.alarm, told);
    for (const SenseSurprise& sense : bits.senses) standing_out[sense.sense] += sense.alarm;
  }
  EXPECT_LE(alarms, 4);
  EXPECT_GE(alarms, 2);
  for (const auto& [sense, count] : standing_out) EXPECT_LE(count, 4) << sense;
  for (const auto& [name, threshold] : model.thresholds) {
    EXPECT_GE(threshold, -std::log2(rate) - 1e-12) << name;
  }
}

TEST(SurpriseModel, IsTheHandsOwnWhereOneWasFittedToIt) {
  const std::filesystem::path shipped = "config/touch/percept_surprise";
  for (const std::string hand : {"sdh2", "bh8", "pg70"}) {
    EXPECT_EQ(SurpriseModel::load_for(shipped, hand).hand, hand);
    EXPECT_EQ(SurpriseModel::load_for(shipped / (hand + ".yaml"), "mine").hand, hand);
  }
  EXPECT_EQ(SurpriseModel::load_for(shipped, "mine").hand, "sdh2");
  EXPECT_EQ(SurpriseModel::load_for(shipped, "").hand, "sdh2");
  EXPECT_THROW(SurpriseModel::load_for(shipped / "mine.yaml", "sdh2"), geometry::InputError);
  EXPECT_THROW(SurpriseModel::load_for("config/touch", "sdh2"), geometry::InputError);
}

TEST(SurpriseModel, IsReadAsItWasWritten) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "percept_surprise";
  std::filesystem::create_directories(folder);
  SurpriseModel model = SurpriseModel::unfitted();
  model.scales["closure"] = 0.0125;
  model.hand = "sdh2";
  model.save(folder / "model.yaml", "by a test");
  const SurpriseModel read = SurpriseModel::load(folder / "model.yaml");
  EXPECT_EQ(read.scales, model.scales);
  EXPECT_EQ(read.shares, model.shares);
  EXPECT_EQ(read.thresholds, model.thresholds);
  EXPECT_EQ(read.hand, "sdh2");
  geometry::write_whole_file(folder / "bad.yaml", "version: 1\nscales: {closures: 1}\n", "A model");
  EXPECT_THROW(SurpriseModel::load(folder / "bad.yaml"), geometry::InputError);
  model.scales["closure"] = 0;
  EXPECT_THROW(model.save(folder / "model.yaml", ""), std::invalid_argument);
  std::filesystem::remove_all(folder);
  EXPECT_THROW(fit_surprise({}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::belief
