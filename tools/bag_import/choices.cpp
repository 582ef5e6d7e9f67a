#include "tools/bag_import/choices.h"

namespace prehend::tools {

void add_bag_import_options(CLI::App& command, BagImportChoices& choices) {
  command
      .add_option("file", choices.file,
                  "A bag of ROS 1, or an MCAP file of ROS 2 (mcap storage of rosbag2)")
      ->required();
  command.add_option("output", choices.output, "The new recording (MCAP)")->required();
  command
      .add_option("-t,--topics", choices.topics,
                  "Only these, * for any text; what --stereo and --depth need is taken besides")
      ->allow_extra_args(false);
  CLI::Option* stereo = command.add_option(
      "--stereo", choices.stereo,
      "Two topics of rectified images, left and right: pairs on /camera/stereo, and /camera/info "
      "from the camera_info beside them");
  stereo->expected(2)->delimiter(',');
  CLI::Option* depth = command.add_option(
      "--depth", choices.depth,
      "A topic of depth images: on /camera/depth, and /camera/info from the camera_info beside it");
  command
      .add_option("--color", choices.color,
                  "With --depth: a topic of images of the same size that are registered to it")
      ->needs(depth);
  depth->excludes(stereo);
  command.add_option("--compression", choices.compression, "none, lz4 or zstd")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}))
      ->capture_default_str();
}

}  // namespace prehend::tools
