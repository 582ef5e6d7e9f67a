// The words of a command line or a parameter that say how a recorded cloud is to be read.

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/perception/recorded_cloud.h"

namespace prehend::perception {
namespace {

using geometry::InputError;

std::vector<double> read_numbers(const std::string& name, const std::string& text,
                                 std::size_t count, const std::string& meaning) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  if (stream.eof() && (numbers.empty() || numbers.size() == count)) return numbers;
  throw InputError("The option " + name + " is '" + text + "'",
                   "Give " + meaning + ", separated by spaces");
}

TableChoice read_table_choice(const std::string& text) {
  TableChoice choice;
  if (text.empty() || text == "auto") return choice;
  if (text == "find" || text == "none") {
    choice.kind = text == "find" ? TableChoice::Kind::kFind : TableChoice::Kind::kNone;
    return choice;
  }
  const auto v = read_numbers("table", text, 4,
                              "auto, find, none, or the plane a x + b y + c z = d as a b c d [m]");
  const Eigen::Vector3d normal =
      v.empty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(v[0], v[1], v[2]);
  if (!(normal.norm() > 1e-9) || !std::isfinite(v[3])) {
    throw InputError("The option table is '" + text + "', a plane without a direction",
                     "Give its normal towards the objects and its distance, e.g. 0 0 1 0.75");
  }
  choice.kind = TableChoice::Kind::kPlane;
  choice.plane_F = {normal.normalized(), v[3] / normal.norm()};
  return choice;
}

}  // namespace

RecordedCloudOptions read_recorded_cloud_options(double scale, const std::string& viewpoint,
                                                 const std::string& up, const std::string& table) {
  RecordedCloudOptions options;
  options.scale = scale;
  options.table = read_table_choice(table);
  if (const auto v =
          read_numbers("viewpoint", viewpoint, 7, "x y z [m] and the quaternion w x y z");
      !v.empty()) {
    const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
    if (!(q.norm() > 0.5 && q.norm() < 2)) {
      throw InputError(
          "The option viewpoint has a quaternion of length " + std::to_string(q.norm()),
          "Give a unit quaternion, w first");
    }
    options.viewpoint = geometry::make_transform(q, {v[0], v[1], v[2]});
  }
  if (const auto v = read_numbers("up", up, 3, "x y z"); !v.empty()) {
    options.up = Eigen::Vector3d(v[0], v[1], v[2]);
    if (!(options.up->norm() > 1e-9)) {
      throw InputError("The option up has no length", "Give a direction like 0 0 1");
    }
  }
  return options;
}

}  // namespace prehend::perception
