#include <cstdio>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/tool_load.h"
#include "prehend/report/charts.h"
#include "tools/calibrate/runs.h"

namespace prehend::tools {
namespace {

using calibration::StillWrench;
using calibration::ToolLoadFit;

std::vector<StillWrench> read_wrenches(const std::string& file) {
  const text::CsvTable table =
      text::read_csv_table(file, 1, "Write a row for each pose: fx,fy,fz,tx,ty,tz,qw,qx,qy,qz");
  static constexpr const char* kNames[] = {"fx", "fy", "fz", "tx", "ty", "tz"};
  std::vector<std::vector<double>> columns;
  for (int i = 0; i < 6; ++i) {
    columns.push_back(table.numbers(table.require(
        kNames[i], i < 3 ? "N, on the sensor, in its frame" : "N m, about the sensor's origin")));
  }
  const std::vector<Eigen::Matrix3d> rotations = rotations_of(table);
  std::vector<StillWrench> poses;
  for (std::size_t r = 0; r < rotations.size(); ++r) {
    StillWrench pose;
    pose.name = fmt::format("line {}", table.lines[r]);
    pose.R_WS = rotations[r];
    pose.force_S = Eigen::Vector3d(columns[0][r], columns[1][r], columns[2][r]);
    pose.torque_S = Eigen::Vector3d(columns[3][r], columns[4][r], columns[5][r]);
    poses.push_back(pose);
  }
  return poses;
}

std::string list_of(const Eigen::Vector3d& v) {
  return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x(), v.y(), v.z());
}

// What each pose adds, by what the poses so far leave open.
void say_progress(const std::vector<StillWrench>& poses) {
  std::string before;
  for (std::size_t n = 1; n <= poses.size(); ++n) {
    std::string now = "nothing is missing";
    try {
      calibration::calibrate_tool_load({poses.begin(), poses.begin() + static_cast<long>(n)});
    } catch (const calibration::DegenerateData& error) {
      now = "missing: " + error.problem();
    }
    if (now != before || n == poses.size()) {
      std::printf("%zu of %zu poses; %s\n", n, poses.size(), now.c_str());
    }
    before = now;
  }
}

}  // namespace

void run_calibrate_wrench(const CalibrateChoices& choices) {
  if (choices.inputs.size() != 1) throw std::invalid_argument("give one CSV file of poses");
  const std::vector<StillWrench> poses = read_wrenches(choices.inputs.front());
  say_progress(poses);
  const ToolLoadFit fit = calibration::calibrate_tool_load(poses);
  std::printf("mass %.4f +- %.4f kg, centre %s +- %s m\n", fit.mass, fit.mass_deviation,
              list_of(fit.center_S).c_str(), list_of(fit.center_deviation).c_str());
  std::printf("bias %s +- %s N, %s +- %s N m\n", list_of(fit.force_bias).c_str(),
              list_of(fit.force_bias_deviation).c_str(), list_of(fit.torque_bias).c_str(),
              list_of(fit.torque_bias_deviation).c_str());
  std::printf("residuals %.3g N and %.3g N m, each axis\n", fit.force_rms, fit.torque_rms);
  for (const auto& pose : fit.poses) {
    if (!pose.used) std::printf("  left out: %s does not agree\n", pose.name.c_str());
  }
  const std::string page_name = page_file(choices);
  if (!page_name.empty()) {
    report::Page page("Bias and load of a force-torque sensor");
    page.add_table(
        {"", "value", "standard deviation"},
        {{"mass [kg]", fmt::format("{:.5f}", fit.mass), fmt::format("{:.5f}", fit.mass_deviation)},
         {"centre [m]", list_of(fit.center_S), list_of(fit.center_deviation)},
         {"force bias [N]", list_of(fit.force_bias), list_of(fit.force_bias_deviation)},
         {"torque bias [N m]", list_of(fit.torque_bias), list_of(fit.torque_bias_deviation)}});
    report::BarChart forces, torques;
    forces.title = "Force's residual of each pose";
    forces.y_label = "[N]";
    torques.title = "Torque's residual of each pose";
    torques.y_label = "[N m]";
    forces.series = {{"x", {}}, {"y", {}}, {"z", {}}};
    torques.series = forces.series;
    std::vector<std::vector<std::string>> rows;
    for (std::size_t i = 0; i < fit.poses.size(); ++i) {
      const calibration::ToolLoadPose& pose = fit.poses[i];
      forces.categories.push_back(std::to_string(i + 1));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        forces.series[axis].values.push_back(pose.force_residual(static_cast<int>(axis)));
        torques.series[axis].values.push_back(pose.torque_residual(static_cast<int>(axis)));
      }
      rows.push_back({std::to_string(i + 1), pose.name, list_of(pose.force_residual),
                      list_of(pose.torque_residual), pose.used ? "used" : "does not agree"});
    }
    torques.categories = forces.categories;
    page.add_chart(report::draw_bar_chart(forces), "Measured minus predicted.");
    page.add_chart(report::draw_bar_chart(torques), "Measured minus predicted.");
    page.add_table({"", "pose", "force [N]", "torque [N m]", ""}, rows);
    write_page(page_name, page);
  }
  if (!choices.out.empty()) {
    write_result(
        choices.out,
        fmt::format("# Found by `prehend calibrate wrench`: force = force_bias + mass * g,\n"
                    "# torque = torque_bias + center x (mass * g), in the sensor's frame.\n"
                    "force_bias: {}  # N\ntorque_bias: {}  # N m\nmass: {:.6g}  # kg, +- "
                    "{:.2g}\ncenter: {}  # m, +- {}",
                    list_of(fit.force_bias), list_of(fit.torque_bias), fit.mass, fit.mass_deviation,
                    list_of(fit.center_S), list_of(fit.center_deviation)),
        "The tool's load");
  }
}

}  // namespace prehend::tools
