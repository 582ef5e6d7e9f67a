// URDFs of strangers who mean harm, as urdfdom reads them for planners and simulations: it would
// call itself down to the stack's end, or take minutes.

#include <string>

#include <gmock/gmock.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/robot_model.h"

namespace prehend::robot {
namespace {

using testing::HasSubstr;

std::string refusal_of(const std::string& text) {
  try {
    parse_urdf(text, "a.urdf");
  } catch (const geometry::InputError& error) {
    return error.what();
  }
  return "";
}

/// Links in a row, each on the one before.
std::string row(int links) {
  std::string text = "<robot name='r'><link name='0'/>";
  for (int i = 1; i < links; ++i) {
    const std::string n = std::to_string(i);
    text += "<link name='" + n + "'/><joint name='j" + n + "' type='fixed'><parent link='" +
            std::to_string(i - 1) + "'/><child link='" + n + "'/></joint>";
  }
  return text + "</robot>";
}

TEST(HostileUrdf, DeepOrLongOnesAreRefused) {
  std::string deep = "<robot name='r'><link name='a'/>";
  for (int i = 0; i < 1000000; ++i) deep += "<a>";
  EXPECT_THAT(refusal_of(deep), HasSubstr("a.urdf has elements nested deeper than 100"));
  EXPECT_THAT(refusal_of(row(200000)), HasSubstr("more than a million"));
  EXPECT_THAT(refusal_of(row(10001)), HasSubstr("'a.urdf' has more than 10000 links"));
  EXPECT_EQ(refusal_of(row(10000)), "");
}

TEST(HostileUrdf, ManyCommentsAreReadInOnePass) {
  std::string text = "<robot name='r'><link name='a'/>";
  for (int i = 0; i < 2000000; ++i) text += "<!---->";
  EXPECT_EQ(refusal_of(text + "</robot>"), "");
}

}  // namespace
}  // namespace prehend::robot
