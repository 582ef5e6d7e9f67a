// What nodes with geometry include: messages, Eigen and the graph's node.
#include "cmake/precompiled/messages.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/graph/node.h"
