#include "nodes/belief/lift_view_server.h"

#include <memory>
#include <string>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/convert/percepts.h"
#include "prehend/belief/percept_view.h"
#include "prehend/geometry/errors.h"

namespace prehend::nodes {

LiftViewServer::LiftViewServer(graph::Node& node, const robot::Platform& platform,
                               const ActForecasts& forecasts)
    : node_(node),
      forecasts_(forecasts),
      patience_(node.declare_parameter<double>(
          {.name = "view_patience",
           .default_value = 5.0,
           .unit = "s",
           .minimum = 0.1,
           .maximum = 7.0,  // the cycle gives up after 8 s
           .description = "wall time to wait for a picture of what was lifted (/percepts/view)",
           .read_only = true})),
      pictures_(node, platform),
      server_(node.serve_action<msgs::HeldLookGoal, msgs::LiftViewFeedback, msgs::LiftViewResult>(
          "/percepts/view", [this](const msgs::HeldLookGoal& goal, Context& context) {
            return view(goal, context);
          })) {}

msgs::LiftViewResult LiftViewServer::view(const msgs::HeldLookGoal& goal, Context& context) {
  msgs::LiftViewResult result;
  const std::string problem = node_.shield("view of what was lifted", [&] {
    const std::shared_ptr<const msgs::ObjectModel> model =
        forecasts_.model(goal.stamp(), goal.object_id());
    if (!model) {
      throw geometry::InputError("nothing is foretold of what was lifted",
                                 "Start the node belief before the cycle, with foretell:=true");
    }
    HeldPicture picture =
        pictures_.take(goal, patience_, [&context] { return context.cancelled(); });
    const surface::ObjectModel object = convert::from_message(*model);
    const belief::LiftedView view{
        picture.camera,
        picture.X_WC,
        convert::from_message(model->table()),
        picture.X_WH,
        std::move(picture.robot_W),
        geometry::transformed(belief::thought_surface(object.mesh_W), picture.X_WO)};
    *result.mutable_view() = convert::to_message(belief::perceived_view(picture.depth, view));
  });
  result.set_problem(problem);
  return result;
}

}  // namespace prehend::nodes
