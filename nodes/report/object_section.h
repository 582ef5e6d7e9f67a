#pragma once

#include <functional>
#include <string>

#include "nodes/report/collected.h"
#include "nodes/report/drawn_robot.h"
#include "prehend/report/page.h"
#include "prehend/surface/object_model.h"

namespace prehend::nodes {

/// Runs one part of the page under its heading; what cannot be drawn is said instead.
void section(report::Page& page, const std::string& heading, const std::function<void()>& write);

/// Length, width and height over the table, and how far they can be relied on where they were
/// predicted; a known object has those of its mesh.
std::string size_text(const surface::ObjectModel& model, const msgs::ObjectModel& message);

/// One object: its completed shape, its mesh, its grasp with the robot at it, and where its other
/// candidates fell.
void add_object(report::Page& page, const Collected& collected, const msgs::CompletedShape& shape,
                const DrawnRobot& robot, const std::string& heading);

}  // namespace prehend::nodes
