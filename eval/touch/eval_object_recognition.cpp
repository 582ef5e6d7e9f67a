// Household objects and scans, recognised by three grasps of the PG70 anywhere: what the pads feel
// and how far the jaws are open.

#include <algorithm>
#include <cstdlib>
#include <map>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "eval/household_objects.h"
#include "eval/touch/experiment.h"
#include "eval/touch/pressing.h"
#include "prehend/touch/grasp_memory.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;

constexpr int kTogether = 3;  // grasps of a question
// Of pads and grasps: others than GraspMemory's constants were chosen on.
constexpr std::uint32_t kReportedSeed = 51;
const std::string kRefused = "refused";
constexpr int kTries = 20;        // for a grasp
constexpr double kAside = 0.006;  // m, of the gripper across the object's middle, at most

// From above: the fingers point down, at any turn, where the pads' lower edges clear the table.
geometry::RigidTransform random_grasp(const Eigen::AlignedBox3d& box, double tip,
                                      std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double top = std::max(tip, box.max().z() - 0.005);
  const Eigen::Vector3d at(box.center().x() + kAside * (2 * unit(random) - 1),
                           box.center().y() + kAside * (2 * unit(random) - 1),
                           tip + (top - tip) * unit(random));
  geometry::RigidTransform X_GB = geometry::RigidTransform::Identity();
  X_GB.linear() = (Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(2 * std::numbers::pi * unit(random), Eigen::Vector3d::UnitZ()))
                      .matrix();
  X_GB.translation() = -(X_GB.linear() * at);
  return X_GB;
}

std::vector<Eigen::VectorXd> grasp(Presser& presser, const geometry::TriangleMesh& mesh, int count,
                                   std::mt19937& random) {
  const contact::Shape shape = contact::Shape::mesh(mesh);
  const double tip = robot::GripperModel().tip_z() + 0.001;
  std::vector<Eigen::VectorXd> grasps;
  for (int tries = 0; tries < kTries * count && static_cast<int>(grasps.size()) < count; ++tries) {
    if (tries == 3 * kTries && grasps.empty()) break;
    const auto pressed = presser.press(shape, random_grasp(geometry::bounds(mesh), tip, random));
    if (!pressed) continue;
    std::vector<touch::FeltFrame> frames;
    for (const auto& frame : pressed->frames) {
      frames.push_back({&presser.pad(), {frame.begin(), frame.end()}});
    }
    grasps.push_back(touch::grasp_features(Eigen::VectorXd::Constant(1, pressed->opening), frames));
  }
  return grasps;
}

Findings object_recognition(const ExperimentOptions& options, report::Page& page) {
  Findings findings;
  findings.title = "object recognition";
  const int taught = options.quick ? 30 : 60, questions = options.quick ? 10 : 30;
  std::vector<eval::EvaluationObject> objects = eval::household_objects();
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  if (shared && *shared) {
    for (eval::EvaluationObject& scan : eval::scanned_objects(shared))
      objects.push_back(std::move(scan));
  }
  for (const bool realistic : {false, true}) {
    const std::string pads = realistic ? "realistic" : "ideal";
    Presser presser({.force = 12, .realistic = realistic, .held = true, .seed = kReportedSeed});
    std::mt19937 random(kReportedSeed + (realistic ? 1 : 0));
    touch::GraspMemory memory;
    std::map<std::string, std::vector<Eigen::VectorXd>> asked;
    std::string left_out;
    for (const eval::EvaluationObject& object : objects) {
      const int count = taught + kTogether * questions;
      const auto grasps = grasp(presser, *object.mesh_B, count, random);
      if (static_cast<int>(grasps.size()) < count) {
        left_out += (left_out.empty() ? "" : ", ") + object.name;
        continue;
      }
      // A household object and a scan may have one name.
      const std::string name = asked.contains(object.name) ? object.name + " (scan)" : object.name;
      memory.teach(name, {grasps.begin(), grasps.begin() + taught});
      asked[name] = {grasps.begin() + taught, grasps.end()};
    }
    for (const int together : {1, kTogether}) {
      std::vector<Row> rows;
      int right = 0, refused = 0, all = 0;
      for (const auto& [name, grasps] : asked) {
        std::map<std::string, int> wrong;
        int own = 0;
        for (std::size_t i = 0; i + together <= grasps.size(); i += together) {
          const auto begin = grasps.begin() + static_cast<std::ptrdiff_t>(i);
          const auto answer = memory.ask({begin, begin + together});
          const std::string said = answer.name.empty() ? kRefused : answer.name;
          refused += answer.name.empty() ? 1 : 0;
          said == name ? ++own : ++wrong[said];
          ++all;
        }
        right += own;
        std::string others;
        for (const auto& [other, times] : wrong) {
          others += fmt::format("{}{} {}", others.empty() ? "" : ", ", times, other);
        }
        rows.push_back(
            {{"object", name}, {"right", static_cast<double>(own)}, {"taken_for", others}});
      }
      const double share = static_cast<double>(right) / all;
      page.add_heading(fmt::format("{} pads, {} grasp{}: {:.1f} % right of {} objects", pads,
                                   together, together > 1 ? "s" : "", 100 * share, asked.size()));
      add_table(page, rows);
      const std::string which = fmt::format("{}_{}", pads, together);
      findings.tables.push_back({"objects_" + which, rows});
      findings.summary.push_back({"right_" + which, share});
      findings.summary.push_back({"refused_" + which, static_cast<double>(refused) / all});
      if (together == kTogether) {
        page.add_verdict(fmt::format("{} pads: {:.1f} % right (wanted: 90)", pads, 100 * share),
                         share >= 0.9);
      }
    }
    findings.summary.push_back({"objects_" + pads, static_cast<double>(asked.size())});
    if (!left_out.empty()) {
      page.add_paragraph("Wider than the jaws open, or too low for the pads: " + left_out + ".");
      findings.summary.push_back({"left_out_" + pads, left_out});
    }
  }
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Objects recognised by grasps", object_recognition);
}
