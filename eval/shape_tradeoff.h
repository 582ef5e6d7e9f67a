#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "prehend/fidelity/front.h"

namespace prehend::eval {

/// One setting of the shape stages on some objects, or one way of matching stereo.
struct Measured {
  fidelity::Setting setting;  // mean time and mean deviation
  int failed = 0;             // objects of which it gave no mesh
  int objects = 0;
};

/// What the sweep found.
struct ShapeTradeoff {
  std::vector<Measured> shape;   // from segmented cloud to mesh, on semi-global stereo
  std::vector<Measured> stereo;  // matching alone; the deviation of the default shape stages on it
};

/// Settings that are swept: each of some searches with each of some surfaces, from coarse to the
/// library's defaults; `quick` takes every sixth.
std::vector<fidelity::Setting> swept_settings(bool quick);

/// Measures all settings on each case (rendered once): processor time (of
/// all threads, so other programs on the machine matter little), the median of `repetitions`, of
/// completion, normals and surface, and the mean distance of the truth to the
/// mesh. `progress` is told what is at hand. Cases whose object is not found are left out.
/// @throws geometry::InputError when no object is found in any case.
ShapeTradeoff measure_shape_tradeoff(const std::vector<Case>& cases,
                                     const std::vector<fidelity::Setting>& settings,
                                     int repetitions,
                                     const std::function<void(const std::string&)>& progress);

/// The front of what gave a mesh of every object.
fidelity::Front front_of(const ShapeTradeoff& tradeoff, const std::string& machine);

}  // namespace prehend::eval
