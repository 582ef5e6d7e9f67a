// Two clouds of one table become one set of objects.

#include <gmock/gmock.h>
#include <signal.h>

#include <cmath>
#include <mutex>
#include <optional>

#include "msgs/convert/objects.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/launch/supervision_fixture.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

class ViewMerging : public SupervisionTest {
 protected:
  /// What comes on /objects.
  std::optional<msgs::ObjectHypotheses> merged(const std::string& first,
                                               const std::string& second) {
    const auto source = [](const std::string& name, const std::string& file) {
      return std::vector<std::string>{"--",      "cloud_source",  "--name",  name,
                                      "--param", "file:=" + file, "--param", "world:=file",
                                      "--param", "up:=0 0 1",     "--remap", "/objects:=/views"};
    };
    std::vector<std::string> arguments = source("first", first);
    for (const std::string& argument : source("second", second)) arguments.push_back(argument);
    arguments.insert(arguments.end(), {"--", "view_merging"});
    ChildProgram program("container", arguments, scratch_.path("output.txt"), registry_.endpoint());

    graph::NodeOptions options;
    options.name = "listener";
    options.registry = registry_.endpoint();
    graph::Node node(options);
    std::mutex mutex;
    std::optional<msgs::ObjectHypotheses> result;
    const graph::Subscription subscription = node.subscribe<msgs::ObjectHypotheses>(
        "/objects", graph::QoS::latched(),
        [&](const graph::Received<msgs::ObjectHypotheses>& message) {
          const std::lock_guard lock(mutex);
          result = *message;
        });
    node.spin_in_background();
    eventually(
        [&] {
          const std::lock_guard lock(mutex);
          return result.has_value();
        },
        seconds(30));
    ::kill(program.pid(), SIGINT);
    EXPECT_EQ(program.wait(seconds(30)), 0) << program.output();
    const std::lock_guard lock(mutex);
    return result;
  }

  graph::Registry registry_{graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*"}};
};

/// A table at the height `table` [m], the top of a can on it and the half that is turned to the
/// viewer at -y or +y, 0.65 m away and as high over the table, who looks at the can's foot. File
/// frame: z up.
std::string half_can(double side, double table = 0) {
  std::string points;
  int count = 0;
  const auto add = [&](double x, double y, double z) {
    points += std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(table + z) + "\n";
    ++count;
  };
  for (int i = -100; i <= 100; ++i) {
    for (int k = -100; k <= 100; ++k) {
      const double x = i * 3e-3, y = k * 3e-3;
      const bool hidden = std::abs(x) < 0.04 && side * y < 0.035 && side * y > -0.2;
      if (!hidden) add(x, y, (i * 7 + k * 3 + 1000) % 5 * 1e-4);
    }
  }
  for (int i = 0; i <= 90; ++i) {
    for (int k = 1; k <= 60; ++k) {
      const double angle = 3.14159 * i / 90.0;
      add(0.03 * std::cos(angle), side * 0.03 * std::sin(angle), k * 2e-3);
    }
  }
  for (int i = -15; i <= 15; ++i) {
    for (int k = -15; k <= 15; ++k) {
      if (std::hypot(i, k) <= 15) add(i * 2e-3, k * 2e-3, 0.12);
    }
  }
  const Eigen::Vector3d eye(0, side * 0.65, table + 0.65);
  const Eigen::Quaterniond turn(geometry::look_at(eye, {0, 0, table}).linear());
  std::string viewpoint;
  for (const double value : {eye.x(), eye.y(), eye.z(), turn.w(), turn.x(), turn.y(), turn.z()}) {
    viewpoint += " " + std::to_string(value);
  }
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
         std::to_string(count) + "\nHEIGHT 1\nVIEWPOINT" + viewpoint + "\nPOINTS " +
         std::to_string(count) + "\nDATA ascii\n" + points;
}

TEST_F(ViewMerging, JoinsTheSidesThatTwoCamerasSaw) {
  const auto message =
      merged(scratch_.write("a.pcd", half_can(-1)), scratch_.write("b.pcd", half_can(1)));
  ASSERT_TRUE(message.has_value());
  ASSERT_EQ(message->problem(), "");
  ASSERT_EQ(message->objects_size(), 1);
  EXPECT_THAT(message->notes(0), HasSubstr("2 views"));
  const perception::SegmentedScene scene = convert::from_message(*message);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : scene.objects[0].cloud_W.points) box.extend(p);
  EXPECT_NEAR(box.min().y(), -0.03, 0.002);
  EXPECT_NEAR(box.max().y(), 0.03, 0.002);
  EXPECT_NEAR(scene.table_W.offset, 0, 0.002);
}

TEST_F(ViewMerging, SaysWhenThePosesCannotBe) {
  const auto message =
      merged(scratch_.write("a.pcd", half_can(-1)), scratch_.write("b.pcd", half_can(1, 0.2)));
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->objects_size(), 0);
  EXPECT_THAT(message->problem(), HasSubstr("table"));
}

}  // namespace
}  // namespace prehend::testing
