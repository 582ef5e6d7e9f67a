#include "prehend/belief/percepts.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace prehend::belief {
namespace {

const std::array<const char*, 2> kMoments{"closed", "lifted"};

void require_finite(bool finite, const std::string& what) {
  if (!finite) throw std::invalid_argument("Percepts: " + what + " is not finite");
}

void check_wrench(const std::optional<Wrench>& wrench, const std::string& name) {
  if (!wrench) return;
  require_finite(wrench->force.allFinite(), "the wrist's force, " + name + ",");
  require_finite(wrench->torque.allFinite(), "the wrist's torque, " + name + ",");
}

}  // namespace

void check_percepts(const Percepts& percepts) {
  for (const PerceivedPad& pad : percepts.pads) {
    for (std::size_t moment = 0; moment < kMoments.size(); ++moment) {
      const PadImage& image = pad.at[moment];
      const std::string where = fmt::format("pad '{}', {}: ", pad.name, kMoments[moment]);
      require_finite(std::isfinite(image.force), where + "force");
      require_finite(std::isfinite(image.area), where + "area");
      require_finite(image.center_P.allFinite(), where + "centre");
      for (std::size_t i = 0; i < image.texels.size(); ++i) {
        require_finite(std::isfinite(image.texels[i]), where + fmt::format("texel {}", i));
      }
    }
    require_finite(std::isfinite(pad.touched_at.value_or(0)),
                   fmt::format("pad '{}': where it first touched", pad.name));
  }
  for (const PerceivedMotor& motor : percepts.motors) {
    for (std::size_t moment = 0; moment < kMoments.size(); ++moment) {
      require_finite(std::isfinite(motor.at[moment].value_or(0)),
                     fmt::format("motor '{}', {}: position", motor.name, kMoments[moment]));
    }
    require_finite(std::isfinite(motor.stopped_after.value_or(0)),
                   fmt::format("motor '{}': when it stopped", motor.name));
  }
  check_wrench(percepts.closing, "closing");
  for (std::size_t m = 0; m < kMoments.size(); ++m) check_wrench(percepts.wrist[m], kMoments[m]);
  require_finite(std::isfinite(percepts.weight.value_or(0)), "the weight");
  if (percepts.view) {
    require_finite(std::isfinite(percepts.view->area), "the view: area");
    require_finite(percepts.view->center_C.allFinite(), "the view: middle");
    require_finite(percepts.view->spread.allFinite(), "the view: spread");
  }
}

}  // namespace prehend::belief
