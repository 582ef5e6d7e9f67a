// A sensor of pads in a shared library: some rows say nothing, the others the mean of the present
// force and the one of the frame before, and now and then a count too much.

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/simulation/sensors/pad_sensor.h"

namespace {

using prehend::simulation::PadSensor;
using prehend::simulation::PadSensorParameter;
using prehend::simulation::PadTexels;
using Values = std::map<std::string, double>;

class DeadRows final : public PadSensor {
 public:
  DeadRows(const PadTexels& texels, const Values& values, std::uint32_t seed)
      : texels_(texels),
        first_(static_cast<int>(values.at("first"))),
        end_(first_ + static_cast<int>(values.at("count"))),
        jitter_(values.at("jitter")),
        random_(seed),
        before_(static_cast<std::size_t>(texels.rows * texels.columns), 0.0) {
    if (end_ > texels.rows) {
      throw std::invalid_argument("dead_rows: a pad of " + std::to_string(texels.rows) +
                                  " rows has no row " + std::to_string(end_ - 1));
    }
  }

  std::vector<std::uint16_t> read(const std::vector<double>& forces, double /*dt*/) override {
    std::vector<std::uint16_t> counts;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      const int row = static_cast<int>(i) / texels_.columns;
      const double force = 0.5 * (forces[i] + before_[i]);
      double count = std::floor(force / texels_.newton_per_count);
      if (count > 0 && drawn() < jitter_) count += 1;
      if (row >= first_ && row < end_) count = 0;
      counts.push_back(static_cast<std::uint16_t>(
          std::clamp(count, 0.0, static_cast<double>(texels_.full_scale))));
    }
    before_ = forces;
    return counts;
  }

  std::vector<double> save() const override {
    std::vector<double> state = before_;
    state.push_back(random_);
    return state;
  }
  void restore(const std::vector<double>& state) override {
    before_.assign(state.begin(), state.end() - 1);
    random_ = static_cast<std::uint32_t>(state.back());
  }

 private:
  // 0 to 1, by a generator whose whole state is one number that a double has exactly.
  double drawn() {
    random_ = 1664525 * random_ + 1013904223;
    return random_ / 4294967296.0;
  }

  PadTexels texels_;
  int first_, end_;
  double jitter_;
  std::uint32_t random_;
  std::vector<double> before_;  // N
};

class DeadRowsModel final : public prehend::simulation::PadSensorModel {
 public:
  std::string name() const override { return "dead_rows"; }
  std::vector<PadSensorParameter> parameters() const override {
    return {{"first", 0, 0, 1e3}, {"count", 2, 0, 1e3}, {"jitter", 0, 0, 1}};
  }
  std::unique_ptr<PadSensor> make(const PadTexels& texels, const Values& values,
                                  std::uint32_t seed) const override {
    return std::make_unique<DeadRows>(texels, values, seed);
  }
};

}  // namespace

extern "C" {

int prehend_sensor_interface() { return prehend::simulation::kSensorInterface; }

prehend::simulation::PadSensorModel* prehend_create_sensor() { return new DeadRowsModel; }
}
