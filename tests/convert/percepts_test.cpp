#include "msgs/convert/percepts.h"

#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using testing::HasSubstr;

belief::Percepts felt() {
  belief::Percepts percepts;
  belief::PadImage image;
  image.texels = {0, 0.5, 1.5};
  image.force = 2;
  image.center_P = {0.001, -0.002, 0};
  image.area = 2.3e-5;
  percepts.pads.push_back({"left", {image, {}}, 0.1});
  percepts.pads.push_back({"right", {}, std::nullopt});
  percepts.motors.push_back({"jaw", {0.02, std::nullopt}, 0.4});
  percepts.closing = belief::Wrench{{1, 2, 3}, {0.1, 0.2, 0.3}};
  percepts.wrist[belief::kLifted] = belief::Wrench{{0, 0, -4}, {0, 0, 0}};
  percepts.weight = 4;
  belief::PerceivedView view;
  view.depth = geometry::DepthImage(2, 1, std::numeric_limits<float>::quiet_NaN());
  view.depth.at(1, 0) = 0.5F;
  view.area = 0.004;
  view.center_C = {0.01, 0.1, -0.02};
  view.spread = {0.02, 0.03};
  percepts.view = view;
  return percepts;
}

std::string refused(const msgs::Percepts& message) {
  try {
    from_message(message);
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PerceptMessages, SayWhatWasPerceived) {
  const belief::Percepts before = felt(), after = from_message(to_message(before));
  ASSERT_EQ(after.pads.size(), 2u);
  EXPECT_EQ(after.pads[0].name, "left");
  EXPECT_EQ(after.pads[0].at[belief::kClosed].texels, before.pads[0].at[belief::kClosed].texels);
  EXPECT_EQ(after.pads[0].at[belief::kClosed].force, 2);
  EXPECT_EQ(after.pads[0].at[belief::kClosed].area, 2.3e-5);
  EXPECT_EQ(after.pads[0].at[belief::kClosed].center_P, Eigen::Vector3d(0.001, -0.002, 0));
  EXPECT_TRUE(after.pads[0].at[belief::kLifted].texels.empty()) << "no sensor stays none";
  EXPECT_EQ(after.pads[0].touched_at, 0.1);
  EXPECT_FALSE(after.pads[1].touched_at.has_value());
  ASSERT_EQ(after.motors.size(), 1u);
  EXPECT_EQ(after.motors[0].at[belief::kClosed], 0.02);
  EXPECT_FALSE(after.motors[0].at[belief::kLifted].has_value());
  EXPECT_EQ(after.motors[0].stopped_after, 0.4);
  ASSERT_TRUE(after.closing.has_value());
  EXPECT_EQ(after.closing->torque, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_FALSE(after.wrist[belief::kClosed].has_value());
  EXPECT_EQ(after.wrist[belief::kLifted]->force.z(), -4);
  EXPECT_EQ(after.weight, 4);
  ASSERT_TRUE(after.view.has_value());
  EXPECT_EQ(after.view->depth.width, 2);
  EXPECT_TRUE(std::isnan(after.view->depth.at(0, 0)));
  EXPECT_EQ(after.view->depth.at(1, 0), 0.5F);
  EXPECT_EQ(after.view->area, 0.004);
  EXPECT_EQ(after.view->center_C, Eigen::Vector3d(0.01, 0.1, -0.02));
  EXPECT_EQ(after.view->spread, Eigen::Vector2d(0.02, 0.03));
  EXPECT_FALSE(from_message(msgs::Percepts()).view.has_value());
}

TEST(PerceptMessages, AreRefusedByNameWhereTheyAreNoNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  msgs::Percepts message = to_message(felt());
  message.set_weight(nan);
  EXPECT_THAT(refused(message), HasSubstr("the weight is not finite"));
  message = to_message(felt());
  message.mutable_pads(0)->mutable_closed()->set_texels(1, std::numeric_limits<float>::infinity());
  EXPECT_THAT(refused(message), HasSubstr("pad 'left', closed: force is not finite"));
  message = to_message(felt());
  message.mutable_pads(0)->mutable_closed()->set_texels(1, -1);
  EXPECT_THAT(refused(message), HasSubstr("pad 'left' with a texel that pulls"));
  message = to_message(felt());
  message.mutable_motors(0)->set_closed(nan);
  EXPECT_THAT(refused(message), HasSubstr("motor 'jaw', closed: position"));
  message = to_message(felt());
  message.mutable_view()->set_area(nan);
  EXPECT_THAT(refused(message), HasSubstr("the view: area is not finite"));
  message.mutable_view()->set_area(-1);
  EXPECT_THAT(refused(message), HasSubstr("negative area"));
  message = to_message(felt());
  message.mutable_view()->set_width(3);
  EXPECT_THAT(refused(message), HasSubstr("size"));
  message.mutable_view()->set_width(4000000000U);
  EXPECT_THAT(refused(message), HasSubstr("4096 pixels"));
  EXPECT_EQ(from_message(msgs::Percepts()).pads.size(), 0u) << "a robot without any sensor";
}

TEST(PerceptMessages, TellWhatCameNearest) {
  belief::PerceptForecast forecast;
  forecast.possible.push_back({"model", 0, 0, 0.7, felt()});
  forecast.possible.push_back({"alternative 1", 0.003, 0, 0.3, felt()});
  forecast.problems = {"alternative 2: does not stand"};
  EXPECT_EQ(to_message(forecast).possible_size(), 2);
  EXPECT_EQ(to_message(forecast).problems(0), "alternative 2: does not stand");
  belief::PerceptSurprise surprise;
  surprise.bits = 31.5;
  surprise.threshold = 30;
  surprise.alarm = true;
  surprise.senses.push_back({"weight", "", 31.5, 30, true});
  surprise.likeliest = 1;
  const msgs::PerceptSurprise message = to_message(surprise, forecast, felt());
  EXPECT_EQ(message.likeliest().shape(), "alternative 1");
  EXPECT_EQ(message.likeliest().along(), 0.003);
  EXPECT_TRUE(message.alarm());
  EXPECT_EQ(message.senses(0).sense(), "weight");
  EXPECT_EQ(message.perceived().weight(), 4);
}

}  // namespace
}  // namespace prehend::convert
