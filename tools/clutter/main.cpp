// Scenes of things that were dropped until they rest: what `prehend clutter` starts.

#include <cstdio>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/perception/image_files.h"
#include "prehend/simulation/clutter_scene.h"
#include "prehend/simulation/stereo_renderer.h"
#include "tools/clutter/choices.h"

namespace {

namespace fs = std::filesystem;
using namespace prehend;
using geometry::InputError;

std::vector<simulation::VisibleBody> seen(const simulation::Scene& scene) {
  std::vector<simulation::VisibleBody> bodies;
  for (const simulation::SceneObject& object : scene.objects) {
    auto mesh = std::make_shared<const geometry::TriangleMesh>(simulation::object_mesh(object));
    const double height = geometry::bounds(*mesh).max().z();
    bodies.push_back({object.name, std::move(mesh), object.pose(), object.texture, height});
  }
  return bodies;
}

int run(const tools::ClutterChoices& choices) {
  simulation::ClutterOptions options = choices.options;
  if (!choices.center.empty()) options.center = {choices.center[0], choices.center[1]};
  if (!choices.size.empty()) options.size = {choices.size[0], choices.size[1]};
  const auto solids = simulation::read_clutter_solids(choices.meshes, choices.scale);
  const fs::path out = choices.out, meshes = out / "meshes";
  std::error_code error;
  fs::create_directories(meshes, error);
  if (error) {
    throw InputError("'" + meshes.string() + "' cannot be made: " + error.message(),
                     "Give another --out");
  }
  int fewer = 0;
  for (int i = 0; i < choices.scenes; ++i, ++options.seed) {
    const fs::path file = out / fmt::format("clutter_{:03}.yaml", i);
    if (!choices.overwrite && fs::exists(file, error)) {
      throw InputError("'" + file.string() + "' is there", "Give another --out, or --overwrite");
    }
    const auto progress = [&](int bodies) {
      if (isatty(STDERR_FILENO) == 0) return;
      fmt::print(stderr, "\r{}: {} of {} lie ", file.string(), bodies, options.count);
    };
    const auto bodies = simulation::drop_clutter(solids, options, progress);
    const simulation::Scene scene =
        simulation::clutter_scene(solids, bodies, meshes, choices.varied, options.seed);
    const auto truths = simulation::clutter_truth(solids, bodies, scene);
    simulation::write_clutter(file, solids, bodies, truths, scene);
    fs::path picture = file;
    perception::write_color_image(picture.replace_extension(".png"),
                                  simulation::render_stereo(scene, seen(scene)).left);
    double least = 1;
    std::size_t touching = 0, borne = 0;
    for (const simulation::ClutterTruth& truth : truths) {
      least = std::min(least, truth.visible());
      touching += truth.touches.empty() ? 0 : 1;
      borne += truth.borne_by.empty() ? 0 : 1;
    }
    fewer += static_cast<int>(bodies.size()) < options.count ? 1 : 0;
    if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r{:90}\r", "");
    fmt::print(
        "{}: {} bodies, {} touch another, {} lie on another, the most hidden is seen to {:.0f} %\n",
        file.string(), bodies.size(), touching, borne, 100 * least);
    std::fflush(stdout);
  }
  if (fewer > 0) {
    fmt::print("{} of {} have fewer than {} bodies, as no place was found for more\n", fewer,
               choices.scenes, options.count);
  }
  fmt::print("Try one: prehend launch demo 'scene:={}' task:=clear_table\n",
             (out / "clutter_000.yaml").string());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Scenes of things that were dropped until they rest", "scene_clutter");
  tools::ClutterChoices choices;
  tools::add_clutter_options(app, choices);
  try {
    app.parse(argc, argv);
    return run(choices);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "prehend clutter: {}\n", error.what());
    return 1;
  }
}
