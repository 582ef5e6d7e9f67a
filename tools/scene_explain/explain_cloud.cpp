#include "tools/scene_explain/explain_cloud.h"

#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/chosen_chain.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/closing/widest_opening.h"
#include "prehend/perception/recorded_cloud.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"
#include "prehend/shape/body_evidence.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/surface/model.h"
#include "prehend/surface/size_on_table.h"
#include "prehend/text/tree_file.h"

namespace prehend::tools {
namespace {

using perception::SegmentedScene;
using simulation::Explanation;
using simulation::kNoBound;

class CloudExplainer {
 public:
  explicit CloudExplainer(const CloudToExplain& cloud) : cloud_(cloud) {
    seeing_.segmentation.body_evidence = shape::log_odds_of_one_body;
    if (!cloud.split.empty()) {
      std::optional<double> widest_opening;
      if (!cloud.platform.empty()) {
        const auto file = robot::platform_file(text::tree_file("config/robots"), cloud.platform);
        widest_opening = grasp::widest_opening(robot::read_platform(file).hand);
      }
      perception::choose_splitting(cloud.split, widest_opening, &seeing_.segmentation);
    }
    if (cloud.budget > 0 || cloud.tolerance > 0) choose_chain();
  }

  Explanation explain() {
    perception::RecordedCloud whole = perception::interpret_recorded_cloud(
        geometry::read_cloud_file(cloud_.file),
        perception::read_recorded_cloud_options(cloud_.scale, cloud_.viewpoint, cloud_.up,
                                                cloud_.table));
    all_points_ = whole.cloud_C.size();
    const perception::RecordedCloud recorded = thinned(std::move(whole), seeing_.points);
    const SegmentedScene scene =
        perception::segment_recorded_cloud(recorded, seeing_.segmentation, seeing_.table);
    tell_view(recorded, scene);
    tell_points_left_out(scene);
    tell_objects(scene);
    return std::move(out_);
  }

 private:
  void choose_chain() {
    const fidelity::ChosenChain chain = fidelity::choose_chain(
        text::tree_file("config/fidelity"),
        fidelity::chain_front_name(fidelity::ChainInput::kCloud, cloud_.hand, cloud_.platform),
        cloud_.budget, cloud_.tolerance);
    fidelity::apply_first_stage(chain.front, chain.setting, &seeing_);
    shape_ =
        fidelity::shape_options(stage_setting(chain.front, chain.setting, fidelity::Stage::kShape));
    modelled("all stages",
             fmt::format("chosen of measured chains: {} ({})", to_string(chain.setting),
                         measured_text(chain.front, chain.setting)));
  }

  void tell_view(const perception::RecordedCloud& recorded, const SegmentedScene& scene) {
    const geometry::PointCloud& cloud = recorded.cloud_C;
    modelled("cloud", cloud.organized()
                          ? fmt::format("a picture of {} x {} pixels", cloud.width, cloud.height)
                          : fmt::format("{} points without an order", cloud.size()));
    const Eigen::Vector3d p = scene.X_WC.translation();
    modelled("table", recorded.hypothetical_table_C
                          ? "made up, under the lowest point"
                          : fmt::format("a plane, {:.2f} m below the camera",
                                        scene.table_W.signed_distance(p)));
    out_.remarks = recorded.notes;
    if (cloud.size() < all_points_) {
      left_out(
          fmt::format("{} of {} points of the picture", all_points_ - cloud.size(), all_points_),
          "points", kNoBound, "", "what is thinner than the pixels that are left",
          "of each square of pixels the one of the median depth stays");
    }
  }

  void tell_points_left_out(const SegmentedScene& scene) {
    const perception::PointsLeftOut& points = scene.left_out;
    const auto tell = [&](std::size_t count, const char* where, const std::string& option,
                          const std::string& error, const char* why) {
      if (count == 0) return;
      left_out(fmt::format("{} points {}", count, where), option, kNoBound, "", error, why);
    };
    tell(points.not_finite, "without a depth", "", "nobody knows what is there",
         "nothing was measured");
    tell(points.too_far, "far away", "max_distance", "what is there is not seen",
         "out of any arm's reach");
    tell(points.beside_table, "beside the table", "hull_margin", "what is there is no obstacle",
         "nothing that is grasped stands there");
    tell(points.over_max_height, "high over the table", "max_height",
         "an object that reaches there is marked as cut", "lamps, people, arms");
    tell(points.flying, "flying alone", "", "a body thinner than a pixel",
         "they would join what stands apart");
    if (points.low > 0) {
      left_out(
          fmt::format("{} points of the table or under it", points.low), "min_height",
          points.least_height, "m",
          fmt::format("at most {:.1f} mm of an object's foot at 1 m", 1e3 * points.least_height),
          "as high as the table's noise");
    }
    for (const std::string& dropped : scene.dropped) {
      left_out("what is no object", "", kNoBound, "", "it is no obstacle", dropped);
    }
  }

  void tell_objects(const SegmentedScene& scene) {
    const auto shapes = shape::complete_scene(scene, shape_.completion);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      const std::string name = fmt::format("object {}", i);
      try {
        const surface::ObjectModel model = surface::make_object_model(
            shapes[i].get(), support_of(scene, scene.objects[i]), shape_.model);
        tell_object(name, scene, scene.objects[i], shapes[i].get(), model);
      } catch (const geometry::InputError& error) {
        left_out(name, "", kNoBound, "", "it is no obstacle and not grasped", error.what());
      }
    }
    if (out_.modelled.empty() || scene.objects.empty()) return;
    const shape::CompletionOptions& search = shape_.completion;
    left_out("planes of symmetry between those tried", "orientations, shifts, refine", kNoBound, "",
             "measured on views of known objects",
             fmt::format("{} directions of {} shifts are tried{}", search.orientations,
                         search.shifts, search.refine ? ", then halved round the best" : ""));
    const double concavity = shape_.model.convex_pieces.concavity;
    left_out("dents of objects, for weight and collisions", "pieces", concavity, "m",
             fmt::format("at most {:.1f} mm deep", 1e3 * concavity),
             "convex pieces collide quickly");
  }

  void tell_object(const std::string& name, const SegmentedScene& scene,
                   const perception::ObjectHypothesis& seen, const shape::CompletedShape& shape,
                   const surface::ObjectModel& model) {
    modelled(name,
             fmt::format("{}: {} seen points, {} predicted by {}, confidence {:.2f}",
                         surface::size_text(surface::predicted_size(model, scene.table_W).size),
                         seen.cloud_W.size(), shape.cloud_W.size() - seen.cloud_W.size(),
                         shape::name(shape.method), shape.confidence));
    modelled(name + "'s mesh",
             fmt::format("{} triangles, {:.0f} % of the area guessed; {} convex pieces; {} other "
                         "shapes",
                         model.mesh_W.triangles.size(), 100 * model.guessed_area,
                         model.convex_pieces_W.size(), model.alternatives_W.size()));
    left_out("detail of " + name + " that the mesh has not", "spacing, resolution, finest_detail",
             model.seen_deviation, "m",
             fmt::format("{:.2f} mm, the seen points' mean distance", 1e3 * model.seen_deviation),
             fmt::format("a smooth surface through voxels, on a grid of {:.1f} mm or more: what "
                         "is finer is between the middles of a pad's texels",
                         1e3 * shape_.model.surface.fast_poisson.least_spacing));
    if (!shape.refused.empty()) out_.remarks.push_back(name + ": " + shape.refused);
    if (!model.substitute.empty()) out_.remarks.push_back(name + ": " + model.substitute);
    if (seen.touches_image_border) {
      out_.remarks.push_back(name +
                             ": the picture or max_height cuts it; what is beyond is not "
                             "predicted");
    }
    if (seen.may_be_several) out_.remarks.push_back(name + ": it may be several");
  }

  void modelled(const std::string& what, const std::string& how) {
    out_.modelled.push_back({what, how});
  }
  void left_out(const std::string& what, const std::string& rule, double error, const char* unit,
                const std::string& error_text, const std::string& why) {
    out_.left_out.push_back({what, rule, error, unit, error_text, why});
  }

  const CloudToExplain& cloud_;
  fidelity::SeeingOptions seeing_;
  std::size_t all_points_ = 0;  // of the file
  fidelity::ShapeOptions shape_;
  Explanation out_;
};

}  // namespace

simulation::Explanation explain_cloud(const CloudToExplain& cloud) {
  return CloudExplainer(cloud).explain();
}

}  // namespace prehend::tools
