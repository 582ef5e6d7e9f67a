#pragma once

#include <cstdint>
#include <string>

#include "foxglove/PointCloud.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"

namespace prehend::convert {

/// Frame in which an object's entity stands: the world, until it is carried away.
std::string object_frame(std::uint32_t id);

/// Number of the object that a point of a cloud belongs to when it belongs to none.
inline constexpr std::uint16_t kNoObject = 65535;

/// Entity `object/<id>`: its mesh, each vertex coloured by what it rests on (seen green, mirrored
/// or otherwise predicted blue, touched orange, assumed grey), with metadata. Without a mesh it has
/// none, and says the problem. @throws geometry::InputError for a mesh that is damaged.
::foxglove::SceneEntity object_entity(const msgs::ObjectModel& model);

/// The seen points of all objects: x y z float32 [m, world], red green blue alpha uint8 (the
/// image's colour, else one for each object), object uint16. Points with NaN are left out.
/// @throws geometry::InputError for a cloud that is damaged.
::foxglove::PointCloud objects_cloud(const msgs::ObjectHypotheses& objects);

/// Entity `table`: a square of the plane round what stands on it; none without a plane.
::foxglove::SceneUpdate table_update(const msgs::ObjectHypotheses& objects);

/// Entities `truth/<name>`: where a simulation's objects are, as their names.
::foxglove::SceneUpdate truth_update(const msgs::GroundTruth& truth);

/// Entities `grasp/<object>/<rank>` of the best `most` grasps: an arrow of the approach, spheres
/// where the fingers meet the object, redder the lower their score; and `grasp/<object>/none` with
/// the problem where there is none. Those of the plan of before, which had `before`, that are no
/// more are deleted. @throws geometry::InputError for a pose that is none.
::foxglove::SceneUpdate grasps_update(const msgs::GraspPlan& plan, int most, int before);

}  // namespace prehend::convert
