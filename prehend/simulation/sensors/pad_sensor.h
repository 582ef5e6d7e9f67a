#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace prehend::simulation {

/// The pad whose electronics a sensor is.
struct PadTexels {
  int rows = 0, columns = 0;    // row 0 at the fingertip
  double newton_per_count = 0;  // N, as the pad's file says
  int full_scale = 0;           // counts, the most that a texel says
};

/// A number that a sensor wants to be told.
struct PadSensorParameter {
  std::string name;
  double default_value = 0;
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};

/// One pad's electronics: from true forces to what the controller says.
class PadSensor {
 public:
  virtual ~PadSensor() = default;
  /// The frame `dt` [s, >= 0] after the last one for the texels' true normal forces [N], rows *
  /// columns, row by row: as many counts, 0 to full_scale.
  virtual std::vector<std::uint16_t> read(const std::vector<double>& forces, double dt) = 0;
  /// All that changes, also of what draws at random, as numbers whose count stays the same: a world
  /// is copied, saved and brought back by it. Another one made like this that restores them goes on
  /// bit by bit as this one does.
  virtual std::vector<double> save() const = 0;
  virtual void restore(const std::vector<double>& state) = 0;
};

/// A law of pads' electronics, chosen by name. Recipe for another one: README.md beside this file.
/// Pure virtual, so that sensors in shared libraries need nothing of prehend linked to them.
class PadSensorModel {
 public:
  virtual ~PadSensorModel() = default;
  virtual std::string name() const = 0;  // by which it is chosen: "dead_rows"
  /// Of the file's map `parameters` those that it knows; others are refused.
  virtual std::vector<PadSensorParameter> parameters() const = 0;
  /// @param values of all its parameters, each within its bounds
  /// @param seed of all that it draws; each pad has another one
  /// @throws std::invalid_argument for values that this pad cannot have, in words.
  virtual std::unique_ptr<PadSensor> make(const PadTexels& texels,
                                          const std::map<std::string, double>& values,
                                          std::uint32_t seed) const = 0;
};

/// Of PadSensorModel and PadSensor: a plug-in that was built for another one is not loaded.
constexpr int kSensorInterface = 1;

}  // namespace prehend::simulation
