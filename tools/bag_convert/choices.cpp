#include "tools/bag_convert/choices.h"

namespace prehend::tools {

void add_bag_convert_options(CLI::App& command, BagConvertChoices& choices) {
  command.add_option("file", choices.file, "The recording")->required();
  command.add_option("output", choices.output, "The new file")->required();
  command.add_option(
      "--platform", choices.platform,
      "The robot that is drawn, of --robots without .yaml, or a file; default: none");
  command.add_option("--robots", choices.robots,
                     "Folder of the platforms' files; default: config/robots of prehend");
  command
      .add_option("--images", choices.images,
                  "Pictures of cameras: jpeg, png (exact), raw (as they are) or none")
      ->check(CLI::IsMember({"jpeg", "png", "raw", "none"}))
      ->capture_default_str();
  command.add_flag("--only-views", choices.only_views,
                   "Without the messages that the views are made of");
  command.add_option("--compression", choices.compression, "none, lz4 or zstd")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}))
      ->capture_default_str();
}

}  // namespace prehend::tools
