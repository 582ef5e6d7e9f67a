#include "prehend/fidelity/chain_settings.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/fidelity/knobs.h"
#include "prehend/geometry/errors.h"

namespace prehend::fidelity {
namespace {

constexpr const char* kSeeingSubject = "seeing";
constexpr const char* kSegmentationSubject = "segmentation";
constexpr const char* kMesh = "mesh";  // m, of Setting::other_errors
constexpr std::array kStages{Stage::kSeeing, Stage::kSegmentation, Stage::kShape,
                             Stage::kPlan,   Stage::kMotion,       Stage::kSimulation};

bool is_chain(const Front& front) { return front.subject == "chain"; }

const double* other_error(const Setting& setting, const std::string& name) {
  for (const auto& [key, value] : setting.other_errors) {
    if (key == name) return &value;
  }
  return nullptr;
}

double mesh_error(const Setting& setting) {
  const double* error = other_error(setting, kMesh);
  if (error == nullptr) {
    throw geometry::InputError("The front of the chain does not say how far its meshes are off",
                               "Measure it again with eval_tradeoff chain, or give a budget");
  }
  return *error;
}

perception::Clustering clustering_of(const char* subject, const std::string& value) {
  return knob_is(subject, "clustering", value, "organized", "euclidean")
             ? perception::Clustering::kOrganized
             : perception::Clustering::kEuclidean;
}

int image_points(const std::string& value) {
  if (value == "all") return 0;
  const int points = knob_number<int>(kSegmentationSubject, "points", value);
  if (points < 1000) refuse_knob(kSegmentationSubject, "points", value);
  return points;
}

double table_leaf(const char* subject, const std::string& value) {
  const auto leaf = knob_number<double>(subject, "table_leaf", value);
  if (!(leaf >= 0.002 && leaf <= 0.05)) refuse_knob(subject, "table_leaf", value);
  return leaf;
}

// A chain from images says nothing of a cloud's segmentation, which a budget would then not bound.
void refuse_other_input(const Setting& setting, Stage stage) {
  for (const auto& [own, other] : {std::pair(ChainInput::kImages, ChainInput::kCloud),
                                   std::pair(ChainInput::kCloud, ChainInput::kImages)}) {
    if (stage != first_stage(own) || !begins_with(setting, other)) continue;
    throw geometry::InputError(
        fmt::format("The front is of chains that begin with {}, and what is given is {}",
                    other == ChainInput::kImages ? "images" : "a recorded cloud",
                    own == ChainInput::kImages ? "images" : "a recorded cloud"),
        fmt::format("Name config/fidelity/chain{}.yaml, or the same for another hand",
                    own == ChainInput::kImages ? "" : "_cloud"));
  }
}

const Setting& within_mesh_tolerance(const Front& front, double tolerance) {
  if (front.settings.empty() || !(tolerance > 0)) {
    throw std::invalid_argument("within_mesh_tolerance: no settings, or no positive tolerance");
  }
  const Setting *fastest = nullptr, *closest = &front.settings.front();
  for (const Setting& setting : front.settings) {
    const double error = mesh_error(setting);
    if (error < mesh_error(*closest)) closest = &setting;
    if (error > tolerance) continue;
    if (fastest == nullptr || setting.seconds < fastest->seconds) fastest = &setting;
  }
  if (fastest != nullptr) return *fastest;
  throw UnreachableError(
      fmt::format("No setting of '{}' has a mesh that is off by at most {:.4g} mm", front.subject,
                  1e3 * tolerance),
      fmt::format("Allow as much as the most accurate one: {:.4g} ms, {:.4g} mm",
                  1e3 * closest->seconds, 1e3 * mesh_error(*closest)),
      *closest);
}

}  // namespace

const char* to_string(Stage stage) {
  switch (stage) {
    case Stage::kSeeing:
      return kSeeingSubject;
    case Stage::kSegmentation:
      return kSegmentationSubject;
    case Stage::kShape:
      return "shape";
    case Stage::kPlan:
      return "plan";
    case Stage::kMotion:
      return "motion";
    case Stage::kSimulation:
      return "simulation";
  }
  return "";
}

const char* to_string(ChainInput input) {
  return input == ChainInput::kImages ? "images" : "cloud";
}

ChainInput chain_input(const std::string& word) {
  for (const ChainInput input : {ChainInput::kImages, ChainInput::kCloud}) {
    if (word == to_string(input)) return input;
  }
  throw geometry::InputError("A chain does not begin with '" + word + "'", "Give images or cloud");
}

Stage first_stage(ChainInput input) {
  return input == ChainInput::kImages ? Stage::kSeeing : Stage::kSegmentation;
}

void apply_seeing_setting(const Setting& setting, SeeingOptions* options) {
  for (const auto& [knob, value] : setting.knobs) {
    if (knob == "stereo") {
      const bool block = value == "block_matching", eight = value == "eight_directions";
      if (!block && !eight && value != "semi_global") refuse_knob(kSeeingSubject, knob, value);
      options->stereo.method =
          block ? perception::StereoMethod::kBlockMatching : perception::StereoMethod::kSemiGlobal;
      options->stereo.eight_directions = eight;
    } else if (knob == "clustering") {
      options->segmentation.clustering = clustering_of(kSeeingSubject, value);
    } else if (knob == "search") {
      options->stereo.narrow_search = knob_is(kSeeingSubject, knob, value, "narrow", "all");
    } else if (knob == "binning") {
      if (value != "1" && value != "2" && value != "4") refuse_knob(kSeeingSubject, knob, value);
      options->binning = value.front() - '0';
      // Depth is noisier by as much, and what is no higher than its noise is no object.
      double& least = options->segmentation.min_object_height;
      least =
          std::max(least, options->binning * perception::SegmentationOptions{}.min_object_height);
    } else if (knob == "table_leaf") {
      options->table.leaf_size = table_leaf(kSeeingSubject, value);
    } else {
      unknown_knob(kSeeingSubject, knob);
    }
  }
}

void apply_segmentation_setting(const Setting& setting, SeeingOptions* options) {
  for (const auto& [knob, value] : setting.knobs) {
    if (knob == "clustering") {
      options->segmentation.clustering = clustering_of(kSegmentationSubject, value);
    } else if (knob == "points") {
      options->points = image_points(value);
    } else if (knob == "table_leaf") {
      options->table.leaf_size = table_leaf(kSegmentationSubject, value);
    } else {
      unknown_knob(kSegmentationSubject, knob);
    }
  }
}

Setting stage_setting(const Front& front, const Setting& setting, Stage stage) {
  if (front.subject == to_string(stage)) return setting;
  if (!is_chain(front)) {
    throw geometry::InputError(
        fmt::format("The front of '{}' says nothing of '{}'", front.subject, to_string(stage)),
        fmt::format("Name one of '{}', or config/fidelity/chain.yaml", to_string(stage)));
  }
  refuse_other_input(setting, stage);
  Setting own = setting;
  own.knobs.clear();
  for (const auto& [knob, value] : setting.knobs) {
    const std::size_t dot = std::min(knob.find('.'), knob.size());
    const std::string of = knob.substr(0, dot);
    if (std::none_of(kStages.begin(), kStages.end(),
                     [&](Stage known) { return of == to_string(known); })) {
      unknown_knob("chain", knob);
    }
    if (of == to_string(stage)) own.knobs.emplace_back(knob.substr(dot + 1), value);
  }
  return own;
}

bool begins_with(const Setting& setting, ChainInput input) {
  return other_error(setting, to_string(first_stage(input))) != nullptr;
}

void apply_first_stage(const Front& front, const Setting& setting, SeeingOptions* options) {
  if (begins_with(setting, ChainInput::kCloud)) {
    apply_segmentation_setting(stage_setting(front, setting, Stage::kSegmentation), options);
  } else {
    apply_seeing_setting(stage_setting(front, setting, Stage::kSeeing), options);
  }
}

double stage_seconds(const Setting& setting, Stage stage) {
  const double* seconds = other_error(setting, to_string(stage));
  if (seconds == nullptr) {
    throw geometry::InputError(
        fmt::format("The front of the chain does not say how long '{}' took", to_string(stage)),
        "Measure it again with eval_tradeoff chain");
  }
  return *seconds;
}

std::string measured_text(const Front& front, const Setting& setting) {
  const std::string time = fmt::format("{:.0f} ms", 1e3 * setting.seconds);
  if (front.error_unit == "m") return fmt::format("{}, {:.2f} mm", time, 1e3 * setting.error);
  if (front.subject == to_string(Stage::kPlan)) {
    return fmt::format("{}, {:.0f} % not lifted at the first attempt", time, 100 * setting.error);
  }
  if (!is_chain(front)) return fmt::format("{}, {:.3g} {}", time, setting.error, front.error_unit);
  return fmt::format(
      "{} of processor from {} to grasps, {:.3g} % of the views not lifted at the first attempt, "
      "meshes {:.2f} mm off",
      time, begins_with(setting, ChainInput::kCloud) ? "a cloud" : "images", 100 * setting.error,
      1e3 * mesh_error(setting));
}

double tolerated_error(const Front& front, const Setting& setting) {
  return is_chain(front) ? mesh_error(setting) : setting.error;
}

const Setting& choose_for_stage(const Front& front, double budget, double tolerance) {
  if (is_chain(front) && tolerance > 0 && !(budget > 0)) {
    return within_mesh_tolerance(front, tolerance);
  }
  return choose(front, budget, tolerance);
}

}  // namespace prehend::fidelity
