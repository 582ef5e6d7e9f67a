#include "tools/clutter/choices.h"
#include "prehend/text/command_line.h"

#include <limits>

namespace prehend::tools {

void add_clutter_options(CLI::App& app, ClutterChoices& choices) {
  simulation::ClutterOptions& options = choices.options;
  app.add_option("meshes", choices.meshes, "Folder of closed meshes (.ply .obj .stl .off .dae)")
      ->required();
  app.add_option("--out", choices.out,
                 "Folder to write: clutter_000.yaml, clutter_000_truth.yaml, clutter_000.png, ...; "
                 "meshes go to OUT/meshes")
      ->required();
  app.add_option("--scale", choices.scale, "Metres of a unit of the files; 0.001: millimetres")
      ->check(text::in_range(1e-6, 1e3))
      ->capture_default_str();
  app.add_option("--scenes", choices.scenes, "How many; each with the next seed")
      ->check(text::in_range(1, 100000))
      ->capture_default_str();
  app.add_option("--count", options.count, "Bodies of a scene")
      ->check(text::in_range(1, 12))
      ->capture_default_str();
  const auto share = [&app](const char* name, double& value, const char* what) {
    app.add_option(name, value, what)->check(text::in_range(0.0, 1.0))->capture_default_str();
  };
  share("--touching", options.touching, "Share of bodies that are pushed against another one");
  share("--stacked", options.stacked, "Share that is lowered onto another one");
  share("--leaning", options.leaning, "Share that is tilted and let fall against another one");
  share("--hidden", options.hidden, "Share that is put behind another one, as the camera sees it");
  share(
      "--tumbled", options.tumbled,
      "Share that is dropped in any orientation, whatever it is put beside; leaning ones are not");
  app.add_option("--gap", options.gap, "Between those that stand apart [m]")
      ->check(text::in_range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--center", choices.center, "Of the part of the table that is used, x y [m]")
      ->expected(2)
      ->delimiter(',');
  app.add_option("--size", choices.size, "Its sides along x and y [m], 0.4 0.4")
      ->expected(2)
      ->delimiter(',');
  share("--varied", choices.varied,
        "How far camera, light and image noise are drawn, 0: as config/scenes/demo.yaml has them");
  app.add_option("--seed", options.seed, "Same meshes, options and seed, same scenes")
      ->capture_default_str();
  app.add_flag("--overwrite", choices.overwrite, "Write over scenes that are there");
}

}  // namespace prehend::tools
