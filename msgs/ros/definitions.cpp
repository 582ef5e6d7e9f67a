#include "msgs/ros/definitions.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include <openssl/evp.h>

namespace prehend::ros {
namespace {

using recording::RosError;

// Fields and constants, in the definitions' order; MD5 sums count both.
struct Type {
  const char* name;
  const char* ros1;  // null: ROS 2 alone has it
  const char* ros2;  // null: ROS 1 alone has it
};

constexpr const char* kHeader = "std_msgs/Header header\n";

constexpr Type kBoth(const char* name, const char* fields) { return {name, fields, fields}; }

const std::vector<Type>& plain_types() {
  static const std::vector<Type> kAll = {
      {"std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n",
       "builtin_interfaces/Time stamp\nstring frame_id\n"},
      {"builtin_interfaces/Time", nullptr, "int32 sec\nuint32 nanosec\n"},
      {"builtin_interfaces/Duration", nullptr, "int32 sec\nuint32 nanosec\n"},
      kBoth("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
      kBoth("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
      kBoth("geometry_msgs/Transform", "Vector3 translation\nQuaternion rotation\n"),
      kBoth("geometry_msgs/Twist", "Vector3 linear\nVector3 angular\n"),
      kBoth("geometry_msgs/TransformStamped",
            "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"),
      kBoth("geometry_msgs/Wrench", "Vector3 force\nVector3 torque\n"),
      kBoth("geometry_msgs/WrenchStamped", "std_msgs/Header header\nWrench wrench\n"),
      kBoth("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
      kBoth("sensor_msgs/PointField",
            "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\n"
            "uint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\n"
            "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"),
      kBoth("sensor_msgs/PointCloud2",
            "std_msgs/Header header\nuint32 height\nuint32 width\nPointField[] fields\n"
            "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"),
      kBoth("sensor_msgs/Image",
            "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
            "uint8 is_bigendian\nuint32 step\nuint8[] data\n"),
      kBoth("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
      kBoth("sensor_msgs/RegionOfInterest",
            "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"),
      {"sensor_msgs/CameraInfo",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
       "float64[] D\nfloat64[9] K\nfloat64[9] R\nfloat64[12] P\n"
       "uint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n",
       "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
       "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\n"
       "uint32 binning_x\nuint32 binning_y\nRegionOfInterest roi\n"},
      kBoth("sensor_msgs/JointState",
            "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
            "float64[] effort\n"),
      {"rosgraph_msgs/Clock", "time clock\n", "builtin_interfaces/Time clock\n"},
      {"rosgraph_msgs/Log",
       "byte DEBUG=1\nbyte INFO=2\nbyte WARN=4\nbyte ERROR=8\nbyte FATAL=16\n"
       "std_msgs/Header header\nbyte level\nstring name\nstring msg\nstring file\nstring function\n"
       "uint32 line\nstring[] topics\n",
       nullptr},
      {"rcl_interfaces/Log", nullptr,
       "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\n"
       "string function\nuint32 line\n"},
      {"trajectory_msgs/JointTrajectoryPoint",
       "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
       "duration time_from_start\n",
       "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
       "builtin_interfaces/Duration time_from_start\n"},
      kBoth("trajectory_msgs/JointTrajectory",
            "std_msgs/Header header\nstring[] joint_names\nJointTrajectoryPoint[] points\n"),
      {"trajectory_msgs/MultiDOFJointTrajectoryPoint", nullptr,
       "geometry_msgs/Transform[] transforms\ngeometry_msgs/Twist[] velocities\n"
       "geometry_msgs/Twist[] accelerations\nbuiltin_interfaces/Duration time_from_start\n"},
      {"trajectory_msgs/MultiDOFJointTrajectory", nullptr,
       "std_msgs/Header header\nstring[] joint_names\nMultiDOFJointTrajectoryPoint[] points\n"},
      kBoth("control_msgs/JointTolerance",
            "string name\nfloat64 position\nfloat64 velocity\nfloat64 acceleration\n"),
      {"control_msgs/JointComponentTolerance", nullptr,
       "string joint_name\nuint16 component\nfloat64 position\nfloat64 velocity\n"
       "float64 acceleration\n"},
      kBoth("control_msgs/GripperCommand", "float64 position\nfloat64 max_effort\n"),
      {"actionlib_msgs/GoalID", "time stamp\nstring id\n", nullptr},
      {"actionlib_msgs/GoalStatus",
       "uint8 PENDING=0\nuint8 ACTIVE=1\nuint8 PREEMPTED=2\nuint8 SUCCEEDED=3\nuint8 ABORTED=4\n"
       "uint8 REJECTED=5\nuint8 PREEMPTING=6\nuint8 RECALLING=7\nuint8 RECALLED=8\nuint8 LOST=9\n"
       "GoalID goal_id\nuint8 status\nstring text\n",
       nullptr},
      {"actionlib_msgs/GoalStatusArray", "std_msgs/Header header\nGoalStatus[] status_list\n",
       nullptr},
      {"unique_identifier_msgs/UUID", nullptr, "uint8[16] uuid\n"},
      {"action_msgs/GoalInfo", nullptr,
       "unique_identifier_msgs/UUID goal_id\nbuiltin_interfaces/Time stamp\n"},
      {"action_msgs/GoalStatus", nullptr, "GoalInfo goal_info\nint8 status\n"},
      {"action_msgs/GoalStatusArray", nullptr, "GoalStatus[] status_list\n"},
      // The two numbers before a request's and a response's own fields are those that
      // rmw_cyclonedds puts there: the client's writer, and its count of requests.
      {"action_msgs/CancelGoal_Request", nullptr,
       "uint64 client\nint64 sequence\nGoalInfo goal_info\n"},
      {"action_msgs/CancelGoal_Response", nullptr,
       "uint64 client\nint64 sequence\nint8 return_code\nGoalInfo[] goals_canceling\n"}};
  return kAll;
}

struct Action {
  const char* package;
  const char* name;
  const char *goal1, *goal2;  // of ROS 1 and ROS 2
  const char *result, *feedback;
};

const std::vector<Action>& actions() {
  static const std::vector<Action> kAll = {
      {"control_msgs", "FollowJointTrajectory",
       "trajectory_msgs/JointTrajectory trajectory\nJointTolerance[] path_tolerance\n"
       "JointTolerance[] goal_tolerance\nduration goal_time_tolerance\n",
       "trajectory_msgs/JointTrajectory trajectory\n"
       "trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory\n"
       "JointTolerance[] path_tolerance\nJointComponentTolerance[] component_path_tolerance\n"
       "JointTolerance[] goal_tolerance\nJointComponentTolerance[] component_goal_tolerance\n"
       "builtin_interfaces/Duration goal_time_tolerance\n",
       "int32 SUCCESSFUL=0\nint32 INVALID_GOAL=-1\nint32 INVALID_JOINTS=-2\n"
       "int32 OLD_HEADER_TIMESTAMP=-3\nint32 PATH_TOLERANCE_VIOLATED=-4\n"
       "int32 GOAL_TOLERANCE_VIOLATED=-5\nint32 error_code\nstring error_string\n",
       "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint "
       "desired\n"
       "trajectory_msgs/JointTrajectoryPoint actual\ntrajectory_msgs/JointTrajectoryPoint error\n"},
      {"control_msgs", "GripperCommand", "GripperCommand command\n", "GripperCommand command\n",
       "float64 position\nfloat64 effort\nbool stalled\nbool reached_goal\n",
       "float64 position\nfloat64 effort\nbool stalled\nbool reached_goal\n"},
      // prehend's own: examples/ros/prehend_msgs.
      {"prehend_msgs", "Pick", "int32 object\nint32 grasp\n", "int32 object\nint32 grasp\n",
       "bool success\nstring reason\nuint32 object\n", "string phase\n"}};
  return kAll;
}

std::map<std::string, std::string> all_of_ros1() {
  std::map<std::string, std::string> all;
  for (const Type& type : plain_types()) {
    if (type.ros1) all[type.name] = type.ros1;
  }
  for (const Action& action : actions()) {
    const std::string package = std::string(action.package) + "/", name = action.name;
    all[package + name + "Goal"] = action.goal1;
    all[package + name + "Result"] = action.result;
    all[package + name + "Feedback"] = action.feedback;
    all[package + name + "ActionGoal"] =
        kHeader + ("actionlib_msgs/GoalID goal_id\n" + name) + "Goal goal\n";
    all[package + name + "ActionResult"] =
        kHeader + ("actionlib_msgs/GoalStatus status\n" + name) + "Result result\n";
    all[package + name + "ActionFeedback"] =
        kHeader + ("actionlib_msgs/GoalStatus status\n" + name) + "Feedback feedback\n";
  }
  return all;
}

std::map<std::string, std::string> all_of_ros2() {
  std::map<std::string, std::string> all;
  for (const Type& type : plain_types()) {
    if (type.ros2) all[type.name] = type.ros2;
  }
  const std::string call = "uint64 client\nint64 sequence\n";  // as of CancelGoal_Request
  const std::string goal_id = "unique_identifier_msgs/UUID goal_id\n";
  for (const Action& action : actions()) {
    const std::string package = std::string(action.package) + "/", name = action.name;
    all[package + name + "_Goal"] = action.goal2;
    all[package + name + "_Result"] = action.result;
    all[package + name + "_Feedback"] = action.feedback;
    all[package + name + "_SendGoal_Request"] = call + goal_id + name + "_Goal goal\n";
    all[package + name + "_SendGoal_Response"] =
        call + "bool accepted\nbuiltin_interfaces/Time stamp\n";
    all[package + name + "_GetResult_Request"] = call + goal_id;
    all[package + name + "_GetResult_Response"] =
        call + "int8 status\n" + name + "_Result result\n";
    all[package + name + "_FeedbackMessage"] = goal_id + name + "_Feedback feedback\n";
  }
  return all;
}

const std::map<std::string, std::string>& all_of(Version version) {
  static const std::map<std::string, std::string> kRos1 = all_of_ros1(), kRos2 = all_of_ros2();
  return version == Version::kRos1 ? kRos1 : kRos2;
}

const std::string& fields_of(const std::string& type, Version version) {
  const auto found = all_of(version).find(type);
  if (found == all_of(version).end()) {
    throw RosError("the type '" + type + "' is none that prehend exchanges with ROS");
  }
  return found->second;
}

struct Line {
  std::string type, bare;  // "PointField[]", and without brackets
  std::string rest;
  bool is_constant = false;
};

std::vector<Line> lines_of(const std::string& text) {
  std::vector<Line> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin), gap = text.find(' ', begin);
    Line line;
    line.type = text.substr(begin, gap - begin);
    line.bare = line.type.substr(0, line.type.find('['));
    line.rest = text.substr(gap + 1, end - gap - 1);
    line.is_constant = line.rest.find('=') != std::string::npos;
    lines.push_back(std::move(line));
    begin = end + 1;
  }
  return lines;
}

/// A field's type with its package; nothing for a primitive one.
std::string contained_type(const Line& line, const std::string& within, Version version) {
  if (line.is_constant) return {};
  if (line.bare.find('/') != std::string::npos) return line.bare;
  std::string name = within.substr(0, within.find('/') + 1) + line.bare;
  return all_of(version).count(name) != 0 ? name : std::string();
}

void collect(const std::string& type, Version version, std::vector<std::string>& found) {
  if (std::find(found.begin(), found.end(), type) != found.end()) return;
  found.push_back(type);
  for (const Line& line : lines_of(fields_of(type, version))) {
    const std::string inner = contained_type(line, type, version);
    if (!inner.empty()) collect(inner, version, found);
  }
}

std::string md5_of(const std::string& text) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_Digest(text.data(), text.size(), digest, &size, EVP_md5(), nullptr) != 1) {
    throw RosError("this machine's OpenSSL computes no MD5 sums, that ROS 1 knows its types by");
  }
  std::string hexadecimal;
  for (unsigned int i = 0; i < size; ++i) {
    constexpr const char* kDigits = "0123456789abcdef";
    hexadecimal += kDigits[digest[i] >> 4];
    hexadecimal += kDigits[digest[i] & 15];
  }
  return hexadecimal;
}

}  // namespace

const std::vector<std::string>& action_types() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const Action& action : actions()) {
      names.push_back(std::string(action.package) + "/" + action.name);
    }
    return names;
  }();
  return kNames;
}

std::vector<std::string> message_types(Version version) {
  std::vector<std::string> names;
  for (const auto& one : all_of(version)) names.push_back(one.first);
  return names;
}

bool has_definition(const std::string& type, Version version) {
  return all_of(version).count(type) != 0;
}

std::string definition(const std::string& type, Version version) {
  std::vector<std::string> contained;
  collect(type, version, contained);
  std::string text = fields_of(type, version);
  for (std::size_t i = 1; i < contained.size(); ++i) {
    text +=
        std::string(80, '=') + "\nMSG: " + contained[i] + "\n" + fields_of(contained[i], version);
  }
  return text;
}

const recording::RosType& type_of(const std::string& type, Version version) {
  static std::mutex mutex;
  static std::map<std::pair<std::string, Version>, std::unique_ptr<recording::RosType>> built;
  const std::lock_guard lock(mutex);
  auto& found = built[{type, version}];
  if (!found) {
    found = std::make_unique<recording::RosType>(type, definition(type, version));
  }
  return *found;
}

std::string md5_sum(const std::string& type) {
  std::string constants, fields;
  for (const Line& line : lines_of(fields_of(type, Version::kRos1))) {
    const std::string inner = contained_type(line, type, Version::kRos1);
    std::string& to = line.is_constant ? constants : fields;
    to += (inner.empty() ? line.type : md5_sum(inner)) + " " + line.rest + "\n";
  }
  std::string text = constants + fields;
  if (!text.empty()) text.pop_back();
  return md5_of(text);
}

std::string dds_type_name(const std::string& type) {
  const std::size_t slash = type.find('/');
  const std::string package = type.substr(0, slash), name = type.substr(slash + 1);
  std::string kind = "msg";
  for (const Action& action : actions()) {
    if (package == action.package && name.rfind(std::string(action.name) + "_", 0) == 0) {
      kind = "action";
    }
  }
  if (package == "action_msgs" && name.rfind("CancelGoal_", 0) == 0) kind = "srv";
  return package + "::" + kind + "::dds_::" + name + "_";
}

}  // namespace prehend::ros
