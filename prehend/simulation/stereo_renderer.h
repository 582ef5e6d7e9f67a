#pragma once

#include <cstdint>
#include <vector>

#include "prehend/geometry/image.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {

struct RenderOptions {
  int samples_per_side =
      1;  // 1..4: samples of a pixel = samples_per_side^2; greatly influences time
  bool shadows = true;
  int threads = 2;  // >= 1; does not change the result
};

struct StereoImages {
  geometry::ColorImage left;
  geometry::ColorImage right;
  geometry::DepthImage depth;            // of the left camera, without noise [m], NaN: nothing hit
  geometry::Image<std::int16_t> labels;  // left: index into the bodies, -1 table, -2 nothing
};

/// Ray-traces what the scene's stereo camera sees of `bodies` and the table: procedural texture,
/// Lambert shading with one light, shadows, ambient light, Gaussian pixel noise. Same bodies,
/// options and `frame` (added to the noise seed) -> same images.
/// @throws std::invalid_argument naming a bad option or camera field.
StereoImages render_stereo(const Scene& scene, const std::vector<VisibleBody>& bodies,
                           std::uint32_t frame = 0, const RenderOptions& options = {});

}  // namespace prehend::simulation
