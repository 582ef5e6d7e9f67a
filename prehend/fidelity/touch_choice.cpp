#include "prehend/fidelity/touch_choice.h"

#include <fmt/format.h>

#include "prehend/fidelity/touch_settings.h"
#include "prehend/text/tree_file.h"

namespace prehend::fidelity {
namespace {

void refuse_own_words(const simulation::Scene& scene) {
  const auto refuse = [&scene](const char* key, const char* why) {
    const auto given = scene.given.find(key);
    if (given == scene.given.end()) return;
    throw geometry::InputError(
        fmt::format("{}:{}: {} stands beside a budget or tolerance of touch, {}",
                    scene.file.string(), given->second, key, why),
        "Leave one of the two out");
  };
  for (const char* key : {"step", "physics.step", "physics.integration", "physics.tolerance",
                          "physics.velocity_tolerance", "physics.most_iterations"}) {
    refuse(key, "which chooses how the world is stepped");
  }
  for (const char* key : {"physics.engine", "physics.solver"}) {
    refuse(key, "whose front was measured with the native engine");
  }
  refuse("physics.pads", "whose front is of what pads with texels feel");
}

std::string in_words(const Setting& setting, const std::string& file) {
  std::string text = fmt::format(
      "{}: {:.3g} ms of processor for a simulated second, pads' images {:.2g} % of the largest sum "
      "off those of finer steps",
      to_string(setting), 1e3 * setting.seconds, 100 * setting.error);
  for (const auto& [name, error] : setting.other_errors) {
    if (name == "motion") text += fmt::format(", objects {:.2g} mm", 1e3 * error);
  }
  return text + fmt::format(" ({})", file);
}

}  // namespace

ChosenTouch choose_touch(const TouchRequest& request, TouchWorld world) {
  const std::string subject = world == TouchWorld::kWorld ? "touch" : "touch_hand";
  const std::string file = request.front.empty()
                               ? text::tree_file("config/fidelity/" + subject + ".yaml")
                               : request.front.string();
  const Front front = read_front(file);
  if (front.subject != subject) {
    throw geometry::InputError(
        fmt::format("The front '{}' is of '{}'", file, front.subject),
        fmt::format("Name one of '{}', as config/fidelity/{}.yaml is", subject, subject));
  }
  ChosenTouch chosen{choose(front, request.budget, request.tolerance), ""};
  chosen.text = in_words(chosen.setting, file);
  return chosen;
}

ChosenTouch choose_touch(const TouchRequest& request, const robot::Platform& platform,
                         simulation::Scene* scene) {
  refuse_own_words(*scene);
  const bool on_stage = platform.hand_port == robot::HandPort::kGripper;
  if (!on_stage && platform.hand.pads.empty()) {
    throw geometry::InputError(
        fmt::format("A budget or tolerance of touch does not apply to {}, whose hand has no pads",
                    platform.name),
        "Leave it out; `step` of the scene sets the steps");
  }
  const TouchWorld world = on_stage ? TouchWorld::kWorld : TouchWorld::kRobotWorld;
  ChosenTouch chosen = choose_touch(request, world);
  if (world == TouchWorld::kWorld) {
    apply_touch_setting(chosen.setting, scene);
  } else {
    scene->step = touch_hand_step(chosen.setting);
  }
  return chosen;
}

}  // namespace prehend::fidelity
