#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "prehend/robot/hand_model.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/tactile_sensor.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {

/// The electronics of a robot's pads and wrist, as a scene's `tactile` and `wrench` have them. Its
/// state is its value.
class RobotSensors {
 public:
  /// @throws std::invalid_argument naming the option.
  RobotSensors(const robot::HandModel& hand, const TactileOptions& tactile,
               const std::optional<WrenchSensorOptions>& wrench);

  /// Whether the pads' frames depend on the present forces alone; else they come each period.
  bool ideal_pads() const { return tactile_.is_ideal(); }
  /// What the electronics of pad `pad` make of these forces [N], if they are ideal.
  std::vector<std::uint16_t> ideal_counts(std::size_t pad, const std::vector<double>& forces) const;

  /// The time has gone on by `h` [s]: true when frames of pads that are not ideal are due.
  bool frames_due(double h);
  void take_frame(std::size_t pad, const std::vector<double>& forces);
  /// The last one. @pre !ideal_pads()
  const std::vector<std::uint16_t>& frame(std::size_t pad) const { return frames_[pad]; }

  /// What the wrist's sensor shows of `wrench` now; the same without a sensor.
  ContactWrench shown(const ContactWrench& wrench);

 private:
  TactileOptions tactile_;
  std::vector<TactileSensorOptions> pad_options_;
  std::vector<PadElectronics> pads_;
  std::vector<std::vector<std::uint16_t>> frames_;
  std::vector<std::shared_ptr<const contact::PadLayout>> layouts_;
  std::optional<WrenchSensor> wrist_;
  double age_ = 0;  // s, of the frames
};

}  // namespace prehend::simulation
