// What nodes, the graph and the command include: containers, formatted text, protobuf messages.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/actions.pb.h"
#include "msgs/geometry.pb.h"
#include "msgs/graph.pb.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
