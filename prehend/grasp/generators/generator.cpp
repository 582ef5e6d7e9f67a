#include "prehend/grasp/generators/generator.h"

#include <stdexcept>

#include "prehend/grasp/generators/generators.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

struct Entry {
  const char* name;
  std::unique_ptr<CandidateGenerator> (*make)(const GeneratorOptions&);
};
constexpr Entry kGenerators[] = {
    {"circles", make_circles},     {"segments", make_segments},       {"boxes", make_box_rays},
    {"antipodal", make_antipodal}, {"medial_axis", make_medial_axis},
};

}  // namespace

HandReach hand_reach(const robot::GripperModel& gripper) {
  return {gripper.tip_z(), gripper.pad.length(), gripper.max_opening};
}

void GeneratorOptions::validate() const {
  const text::Require require{"GeneratorOptions."};
  circles.validate();
  require(samples > 0, "samples must be positive");
  require(approaches > 0, "approaches must be positive");
  require(rolls > 0, "rolls must be positive");
  require(standoffs > 0, "standoffs must be positive");
  require(least_engagement > 0, "least_engagement must be positive");
  require(table_clearance >= 0, "table_clearance must not be negative");
  require(friction > 0, "friction must be positive");
}

std::vector<std::string> generator_names() {
  std::vector<std::string> names;
  for (const Entry& entry : kGenerators) names.emplace_back(entry.name);
  return names;
}

std::unique_ptr<CandidateGenerator> make_generator(const std::string& name,
                                                   const GeneratorOptions& options) {
  options.validate();
  for (const Entry& entry : kGenerators) {
    if (name == entry.name) return entry.make(options);
  }
  throw std::invalid_argument("there is no candidate generator '" + name + "'" +
                              text::nearest_match_hint(name, generator_names()));
}

}  // namespace prehend::grasp
