#include "tools/pad_fit/choices.h"

namespace prehend::tools {

void add_pad_fit_options(CLI::App& command, PadFitChoices& choices) {
  command
      .add_option(
          "logs", choices.logs,
          "CSV: time [s], depth or opening [m], force [N], count[0], count[1], ... Of several "
          "files the first one has the frames, the others what it lacks")
      ->required();
  command
      .add_option("--column", choices.columns,
                  "Another name of a column in the files, as force=wrench.force.z; may be repeated")
      ->allow_extra_args(false);
  command
      .add_option("--check", choices.checks,
                  "A log that is not fitted: how well its forces are predicted; may be repeated")
      ->allow_extra_args(false);
  command.add_option("-o,--out", choices.out, "Write the calibration to this YAML file");
  command.add_option("--report", choices.report, "Write a page of residuals to this HTML file");
  command.add_option("--rows", choices.rows, "Rows of the pad")->capture_default_str();
  command.add_option("--columns", choices.texel_columns, "Columns of the pad")
      ->capture_default_str();
  command.add_option("--pitch", choices.pitch, "Distance of its texels [m]")->capture_default_str();
  command.add_option("--full-scale", choices.full_scale, "Counts of a full texel")
      ->capture_default_str();
  command.add_option("--creep-terms", choices.creep_terms, "Terms of the foam's creep, 0 to 3")
      ->capture_default_str();
  command
      .add_option("--hysteresis-terms", choices.hysteresis_terms,
                  "Terms of the foam's hysteresis, 0 to 3")
      ->capture_default_str();
  command.add_flag("--json", choices.json, "Print JSON, for programs");
}

}  // namespace prehend::tools
