#include "nodes/report/fidelity_section.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/convert/fidelity.h"
#include "prehend/fidelity/chain_settings.h"

namespace prehend::nodes {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// What the nodes send with a shape is enough to draw the whole front with the point.
TEST(FidelitySection, DrawsTheFrontWithThePointChosen) {
  const fidelity::Front front = fidelity::read_front("config/fidelity/chain.yaml");
  const fidelity::Setting& setting = fidelity::choose_for_stage(front, 1.05, 0);
  Collected collected;
  msgs::FidelityChoice& choice = *collected.models[3].mutable_fidelity();
  choice = convert::to_message(front, setting, fidelity::measured_text(front, setting));
  choice.set_budget(1.05);
  choice.set_asked_at("mine.yaml:3: budget");
  ASSERT_EQ(choice.front_size(), static_cast<int>(front.settings.size()));
  EXPECT_EQ(choice.front(static_cast<int>(choice.chosen())).seconds(), setting.seconds);
  EXPECT_EQ(choice.front(0).mesh(), fidelity::tolerated_error(front, front.settings[0]));
  report::Page page("run");
  add_fidelity(page, collected);
  EXPECT_THAT(page.html(),
              AllOf(HasSubstr("Speed and accuracy"), HasSubstr("A budget of 1.05 s, mine.yaml:3"),
                    HasSubstr("<svg"), HasSubstr(">chosen<"), HasSubstr("error of the meshes"),
                    HasSubstr("seeing.stereo"), Not(HasSubstr("could not be drawn"))));
}

TEST(FidelitySection, IsNotThereWhereNothingChose) {
  Collected collected;
  collected.models[3].set_valid(true);
  // As it was recorded before the front travelled along.
  collected.shapes[3].mutable_fidelity()->set_knobs("thinning 0.04");
  report::Page page("run");
  const std::string empty = page.html();
  add_fidelity(page, collected);
  EXPECT_EQ(page.html(), empty);
}

}  // namespace
}  // namespace prehend::nodes
