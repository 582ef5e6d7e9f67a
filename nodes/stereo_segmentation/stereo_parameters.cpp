#include "nodes/stereo_segmentation/stereo_parameters.h"

#include <string>

#include "prehend/geometry/errors.h"

namespace prehend::nodes {
namespace {

void declare_method_parameters(graph::Node& node) {
  const perception::StereoOptions o;
  node.declare_parameter<std::string>(
      {.name = "method",
       .default_value = "semi_global",
       .choices = {"semi_global", "block_matching"},
       .description = "of stereo matching; block matching is faster and needs more texture"});
  node.declare_parameter<bool>({.name = "narrow_search",
                                .default_value = o.narrow_search,
                                .description = "search only disparities near which a match of a "
                                               "quarter of the size finds anything"});
  node.declare_parameter<bool>({.name = "match_both_ways",
                                .default_value = o.match_both_ways,
                                .description = "match from the right image, too, for a confidence "
                                               "that knows of occlusions; doubles the time"});
  node.declare_parameter<bool>({.name = "filter",
                                .default_value = o.filter,
                                .description = "fill small holes and smooth, up to edges of the "
                                               "left image"});
  node.declare_parameter<double>({.name = "minimum_confidence",
                                  .default_value = o.min_confidence,
                                  .minimum = 0.0,
                                  .maximum = 1.0,
                                  .description = "less sure disparities are dropped"});
}

}  // namespace

void declare_stereo_parameters(graph::Node& node) {
  const perception::StereoOptions o;
  declare_method_parameters(node);
  const auto declare_count = [&node](const char* name, int value, int minimum, int maximum,
                                     const char* description) {
    node.declare_parameter<int>({.name = name,
                                 .default_value = value,
                                 .unit = "px",
                                 .minimum = minimum,
                                 .maximum = maximum,
                                 .description = description});
  };
  node.declare_parameter<std::string>(
      {.name = "world",
       .default_value = "camera",
       .choices = {"camera", "table"},
       .description = "frame of the objects: that of the camera's pose, or made from the table, as "
                      "it is for cameras without a known pose"});
  node.declare_parameter<std::string>(
      {.name = "input",
       .default_value = "stereo",
       .choices = {"stereo", "depth"},
       .description = "what is looked at: /camera/stereo, or /camera/depth of a depth camera, of "
                      "which nothing is matched",
       .read_only = true});
  node.declare_parameter<int>(
      {.name = "binning",
       .default_value = 1,
       .unit = "px",
       .minimum = 1,
       .maximum = 16,
       .description =
           "pixels of a side that are made one before anything else; 2 is about "
           "seven times faster, and objects, masks and camera are those of the smaller image"});
  node.declare_parameter<std::string>(
      {.name = "process",
       .default_value = "once_per_scene",
       .choices = {"once_per_scene", "every"},
       .description = "which images are looked at: the first after the simulated scene changed "
                      "(recordings: each), or every one"});
  node.declare_parameter<double>({.name = "minimum_depth",
                                  .default_value = o.min_depth,
                                  .unit = "m",
                                  .minimum = 0.01,
                                  .maximum = 100.0,
                                  .description = "nearest depth looked for; smaller costs time"});
  node.declare_parameter<double>({.name = "maximum_depth",
                                  .default_value = o.max_depth,
                                  .unit = "m",
                                  .minimum = 0.02,
                                  .maximum = 1000.0,
                                  .description = "farthest depth looked for"});
  declare_count("block_size", o.block_size, 1, 21, "side of the matched window, odd");
  declare_count("small_step_penalty", o.small_step_penalty, 1, 1000,
                "cost of a disparity step of one pixel");
  declare_count("large_step_penalty", o.large_step_penalty, 2, 1000,
                "cost of a larger step; more than small_step_penalty");
  declare_count("gradient_cap", o.gradient_cap, 1, 127, "clips the derivative that is compared");
  node.declare_parameter<int>({.name = "uniqueness_percent",
                               .default_value = o.uniqueness_percent,
                               .unit = "%",
                               .minimum = 0,
                               .maximum = 100,
                               .description = "by which the best match must win"});
  declare_count("speckle_size", o.speckle_size, 0, 100000, "smaller patches are dropped");
  declare_count("speckle_range", o.speckle_range, 1, 100, "disparity step within a patch");
  declare_count("left_right_tolerance", o.left_right_tolerance, -1, 100,
                "of the left-right check; -1: no check");
  node.declare_parameter<bool>({.name = "eight_directions",
                                .default_value = o.eight_directions,
                                .description = "the full two-pass algorithm"});
  declare_count("subpixel_window", o.subpixel.window, 0, 31,
                "side, odd, of the window in which both images are to agree best, for which what "
                "one-pass semi_global finds is moved by less than a pixel; 0: it is not");
}

void refuse_idle_stereo_parameters(const graph::Node& node) {
  if (node.parameter<std::string>("input") == "depth") {
    for (const char* name :
         {"method", "narrow_search", "match_both_ways", "filter", "minimum_confidence",
          "minimum_depth", "maximum_depth", "block_size", "small_step_penalty",
          "large_step_penalty", "gradient_cap", "uniqueness_percent", "speckle_size",
          "speckle_range", "left_right_tolerance", "eight_directions", "subpixel_window"}) {
      if (!node.is_parameter_given(name)) continue;
      throw geometry::InputError(
          std::string("Parameter ") + name + " is of stereo matching, and input is depth",
          "Leave it away");
    }
  }
  const bool one_pass = node.parameter<std::string>("method") == "semi_global" &&
                        !node.parameter<bool>("eight_directions");
  if (!one_pass && node.is_parameter_given("subpixel_window") &&
      node.parameter<int>("subpixel_window") > 0) {
    throw geometry::InputError(
        "Parameter subpixel_window is of semi_global's one pass, and " +
            std::string(node.parameter<bool>("eight_directions") ? "eight_directions has two"
                                                                 : "method is block_matching"),
        "Leave it away");
  }
}

perception::StereoOptions stereo_options(const graph::Node& node) {
  perception::StereoOptions o;
  o.min_depth = node.parameter<double>("minimum_depth");
  o.max_depth = node.parameter<double>("maximum_depth");
  o.block_size = node.parameter<int>("block_size");
  o.small_step_penalty = node.parameter<int>("small_step_penalty");
  o.large_step_penalty = node.parameter<int>("large_step_penalty");
  o.gradient_cap = node.parameter<int>("gradient_cap");
  o.uniqueness_percent = node.parameter<int>("uniqueness_percent");
  o.speckle_size = node.parameter<int>("speckle_size");
  o.speckle_range = node.parameter<int>("speckle_range");
  o.left_right_tolerance = node.parameter<int>("left_right_tolerance");
  o.eight_directions = node.parameter<bool>("eight_directions");
  o.subpixel.window = node.parameter<int>("subpixel_window");
  if (node.parameter<std::string>("method") == "block_matching") {
    o.method = perception::StereoMethod::kBlockMatching;
  }
  o.narrow_search = node.parameter<bool>("narrow_search");
  o.match_both_ways = node.parameter<bool>("match_both_ways");
  o.filter = node.parameter<bool>("filter");
  o.min_confidence = node.parameter<double>("minimum_confidence");
  return o;
}

}  // namespace prehend::nodes
