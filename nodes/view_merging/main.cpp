#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "msgs/convert/objects.h"
#include "msgs/objects.pb.h"
#include "prehend/graph/node_program.h"
#include "prehend/perception/merged_views.h"
#include "prehend/perception/segmentation.h"

namespace {

using namespace prehend;

void declare_parameters(graph::Node& node) {
  const perception::MergeOptions o;
  node.declare_parameter<int>({.name = "views",
                               .default_value = 2,
                               .minimum = 1,
                               .maximum = 100,
                               .description = "messages that are merged into one"});
  node.declare_parameter<bool>({.name = "align",
                                .default_value = o.align,
                                .description = "correct the views' poses by iterative closest "
                                               "points against the views before them"});
  node.declare_parameter<double>({.name = "min_footprint_overlap",
                                  .default_value = o.min_footprint_overlap,
                                  .minimum = 0.01,
                                  .maximum = 1.0,
                                  .description = "share of the points of either of two views' "
                                                 "objects over the other's footprint that makes "
                                                 "them one"});
  node.declare_parameter<double>({.name = "max_correspondence",
                                  .default_value = o.max_correspondence,
                                  .unit = "m",
                                  .minimum = 1e-4,
                                  .maximum = 1.0,
                                  .description = "align: farther points are not each other's"});
}

void declare_world(graph::Node& node) {
  node.declare_parameter<std::string>(
      {.name = "world",
       .default_value = "table",
       .choices = {"table", "views"},
       .description = "frame of the objects: made from their table, or that of the views"});
}

perception::MergeOptions merge_options(const graph::Node& node) {
  perception::MergeOptions o;
  o.align = node.parameter<bool>("align");
  o.min_footprint_overlap = node.parameter<double>("min_footprint_overlap");
  o.max_correspondence = node.parameter<double>("max_correspondence");
  return o;
}

class ViewMerging {
 public:
  explicit ViewMerging(graph::Node& node) : node_(node) {
    declare_parameters(node);
    declare_world(node);
    publisher_ = node.advertise<msgs::ObjectHypotheses>("/objects", graph::QoS::latched());
    subscription_ = node.subscribe<msgs::ObjectHypotheses>(
        "/views", graph::QoS::queue(32),
        [this](const graph::Received<msgs::ObjectHypotheses>& message) { add(*message); });
  }

 private:
  void add(const msgs::ObjectHypotheses& message) {
    if (!message.problem().empty()) {
      node_.report(graph::Health::kWarning, "a view without objects: " + message.problem());
      return;
    }
    const std::string damage =
        node_.shield("view", [&] { views_.push_back(convert::from_message(message)); });
    if (!damage.empty()) {
      node_.report(graph::Health::kError, "a view is damaged: " + damage);
      return;
    }
    const auto wanted = static_cast<std::size_t>(node_.parameter<int>("views"));
    if (views_.size() < wanted) {
      node_.report(graph::Health::kOk, fmt::format("{} of {} views", views_.size(), wanted));
      return;
    }
    publish(message);
  }

  void publish(const msgs::ObjectHypotheses& last) {
    const std::size_t count = views_.size();
    msgs::ObjectHypotheses merged;
    const std::string problem = node_.shield("views", [&] {
      perception::SegmentedScene scene = perception::as_scene(
          perception::merge_views(std::exchange(views_, {}), merge_options(node_)));
      if (node_.parameter<std::string>("world") == "table") {
        scene = perception::in_table_world(std::move(scene));
      }
      merged = convert::to_message(scene);
      merged.add_notes(fmt::format("{} views were merged", count));
    });
    if (!problem.empty()) {
      merged.Clear();
      *merged.mutable_camera() = last.camera();
      merged.set_problem(problem);
    }
    *merged.mutable_header() = last.header();
    if (merged.problem().empty()) {
      const std::string text = fmt::format("{} objects in {} views", merged.objects_size(), count);
      node_.report(graph::Health::kOk, text);
      node_.log_info("{}", text);
    } else {
      node_.report(graph::Health::kWarning, merged.problem());
    }
    publisher_.publish(std::move(merged));
  }

  graph::Node& node_;
  std::vector<perception::SegmentedScene> views_;
  graph::Publisher<msgs::ObjectHypotheses> publisher_;
  graph::Subscription subscription_;
};

void run(graph::Node& node) {
  const ViewMerging merging(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"view_merging",
     "Merges the objects of several views of one table from cameras with known poses. Takes "
     "/views (object hypotheses, one message a view; remap a segmentation's /objects to it), "
     "publishes one message for every `views` of them on /objects (latched). Views whose tables "
     "disagree are answered with a problem."},
    run);

}  // namespace
