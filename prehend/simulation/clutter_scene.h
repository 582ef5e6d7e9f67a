#pragma once

#include <filesystem>
#include <vector>

#include "prehend/simulation/clutter.h"
#include "prehend/simulation/scene.h"

namespace prehend::simulation {

/// kg, of a thing of that volume [m^3]: 400 kg/m^3, as hollow and light things are, but 30 g to 0.8
/// kg.
double mass_of_volume(double volume);

/// The closed meshes of a folder (.ply, .obj, .stl, .off, .dae), by name: upright as they are, the
/// middle of their foot over the origin; as heavy as mass_of_volume() says. @param scale metres per
/// unit of the files.
/// @throws geometry::InputError for a folder without one, a mesh that is no solid, or one larger
/// than 1 m, as of another unit.
std::vector<ClutterSolid> read_clutter_solids(const std::filesystem::path& folder,
                                              double scale = 1);

/// A scene of the bodies, each with a texture of its own. Their meshes' files are named in `meshes`
/// (NAME.ply; see write_clutter).
/// @param varied 0: the camera, light and noise of Scene{}; 1: turned by up to 25 degrees round
/// what it looks at, 12 up or down, 15 % nearer or farther, 1 to 5 grey levels of noise, light from
/// anywhere above. In between, a share of that. The camera stands farther away, up to half as far
/// again, where one of its images would not show all of each body. @param seed of textures and of
/// what varies.
Scene clutter_scene(const std::vector<ClutterSolid>& solids, const std::vector<ClutterBody>& bodies,
                    const std::filesystem::path& meshes, double varied, std::uint64_t seed);

/// What a body does to others, measured where it is.
struct ClutterTruth {
  std::vector<std::size_t> touches;   // others nearer than 1.5 mm
  std::vector<std::size_t> borne_by;  // of these, where their surface faces up
  double lowest = 0;                  // m, over the table
  double tilt = 0;                    // rad, of its z from the vertical
  /// Pixels of the left image in which it is seen, and in which it would be if it were alone.
  int pixels = 0, alone_pixels = 0;

  /// 0..1; 0 where it is not in the image.
  double visible() const { return alone_pixels > 0 ? 1.0 * pixels / alone_pixels : 0; }
};
std::vector<ClutterTruth> clutter_truth(const std::vector<ClutterSolid>& solids,
                                        const std::vector<ClutterBody>& bodies, const Scene& scene);

/// Writes `file` (a scene), the meshes that it names, and beside it NAME_truth.yaml: of each body
/// how it was put down and its ClutterTruth. @throws geometry::InputError for what cannot be
/// written.
void write_clutter(const std::filesystem::path& file, const std::vector<ClutterSolid>& solids,
                   const std::vector<ClutterBody>& bodies, const std::vector<ClutterTruth>& truths,
                   const Scene& scene);

}  // namespace prehend::simulation
