#include "tools/grasp_plan/printed.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/mesh_files.h"
#include "prehend/grasp/uncertainty.h"
#include "prehend/report/page.h"
#include "prehend/report/pictures.h"
#include "prehend/report/rejections.h"
#include "prehend/report/robot_meshes.h"
#include "prehend/surface/size_on_table.h"
#include "tools/json.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

using geometry::RigidTransform;
using Rows = std::vector<std::vector<std::string>>;

constexpr std::size_t kPictures = 6;  // of the best grasps

std::string metres(const Eigen::Vector3d& p) {
  return fmt::format("{:.3f} {:.3f} {:.3f}", p.x(), p.y(), p.z());
}

std::string remark_of(const grasp::Grasp& grasp) {
  std::string remark = grasp.remark;
  if (grasp.robustness < 0) grasp::add_remark(grasp::kNotAssessed, &remark);
  return remark;
}

const std::vector<std::string> kGraspHeader{"RANK",      "SCORE",    "QUALITY",  "ROBUST",
                                            "EFFORT",    "PRESHAPE", "POSITION", "APPROACH",
                                            "GENERATOR", "REMARK"};

Rows grasp_rows(const PlanChoices& choices, const Planned& planned) {
  Rows rows;
  const auto count = std::min<std::size_t>(planned.plan.grasps.size(),
                                           static_cast<std::size_t>(std::max(0, choices.rows)));
  for (std::size_t i = 0; i < count; ++i) {
    const grasp::Grasp& g = planned.plan.grasps[i];
    rows.push_back(
        {fmt::format("{}{}", i + 1,
                     planned.arm && planned.arm->grasp == static_cast<int>(i) ? " *" : ""),
         fmt::format("{:.3f}", g.score), fmt::format("{:.4f}", g.quality),
         g.robustness < 0 ? "-" : fmt::format("{:.0f} %", 100 * g.robustness),
         fmt::format("{:.0f} %", 100 * g.effort), g.preshape, metres(g.X_WG.translation()),
         metres(g.approach_W), g.generator, remark_of(g)});
  }
  return rows;
}

const std::vector<std::string> kLedgerHeader{"CANDIDATES", "FELL AT", "GENERATOR", "NEAREST MISS"};

Rows ledger_rows(const Planned& planned) {
  std::vector<grasp::Rejection> rejections = planned.plan.rejections;
  std::stable_sort(rejections.begin(), rejections.end(),
                   [](const auto& a, const auto& b) { return a.count > b.count; });
  Rows rows;
  for (const auto& r : rejections) {
    rows.push_back({fmt::format("{} of {}", r.count, planned.plan.candidates), to_string(r.reason),
                    r.generator, r.nearest_miss.empty() ? "-" : r.nearest_miss});
  }
  return rows;
}

const std::vector<std::string> kArmLedgerHeader{"GRASPS", "ARM", "NEAREST MISS"};

Rows arm_ledger_rows(const Planned& planned) {
  Rows rows;
  for (const auto& r : planned.arm->motion.rejections) {
    rows.push_back({fmt::format("{} of {}", r.count, planned.plan.grasps.size()),
                    motion::to_string(r.filter), r.nearest_miss.empty() ? "-" : r.nearest_miss});
  }
  return rows;
}

const std::vector<std::string> kChoiceHeader{"WORTH [s]", "WHAT IS WORTH MOST"};

Rows choice_rows(const Planned& planned) {
  Rows rows;
  for (const planning::Choice& choice : planned.choices) {
    rows.push_back({fmt::format("{:.0f}", choice.worth), choice.text});
  }
  return rows;
}

// What would help, then what was tried and would not.
const std::vector<std::string> kRemedyHeader{"WHAT WOULD HELP"};

Rows remedy_rows(const Planned& planned) {
  Rows rows;
  for (const auto& remedy : planned.remedies.found) rows.push_back({remedy.text});
  for (const auto& one : planned.remedies.in_vain) rows.push_back({"with " + one + ": still none"});
  if (!planned.remedies.complete) {
    rows.push_back({"more was not tried in time (--remedy-budget)"});
  }
  return rows;
}

std::vector<report::Rejected> fallen_candidates(const Planned& planned) {
  std::vector<report::Rejected> fallen;
  for (const auto& r : planned.plan.rejections) {
    fallen.push_back({to_string(r.reason), r.generator, r.count, r.nearest_miss});
  }
  return fallen;
}

std::vector<report::Rejected> fallen_grasps(const Planned& planned) {
  std::vector<report::Rejected> fallen;
  for (const auto& r : planned.arm->motion.rejections) {
    fallen.push_back({motion::to_string(r.filter), "", r.count, r.nearest_miss});
  }
  return fallen;
}

const std::vector<std::string> kSegmentHeader{"SEGMENT", "WAYPOINTS", "DURATION [s]"};

Rows segment_rows(const Planned& planned) {
  Rows rows;
  for (const auto& segment : planned.arm->motion.segments) {
    rows.push_back(
        {motion::to_string(segment.kind), fmt::format("{}", segment.waypoints.size()),
         segment.trajectory ? fmt::format("{:.2f}", segment.trajectory->duration()) : "-"});
  }
  return rows;
}

StageTimes all_times(const PlanTarget& target, const Planned& planned) {
  StageTimes times = target.times;
  times.insert(times.end(), planned.times.begin(), planned.times.end());
  return times;
}

const std::vector<std::string> kTimeHeader{"STAGE", "SECONDS"};

Rows time_rows(const PlanTarget& target, const Planned& planned) {
  Rows rows;
  double sum = 0;
  for (const auto& [name, seconds] : all_times(target, planned)) {
    rows.push_back({name, fmt::format("{:.3f}", seconds)});
    sum += seconds;
  }
  rows.push_back({"all", fmt::format("{:.3f}", sum)});
  return rows;
}

void print_rows(const std::vector<std::string>& header, Rows rows) {
  if (rows.empty()) return;
  rows.insert(rows.begin(), header);
  print_table(rows);
  std::printf("\n");
}

std::string verdict(const Planned& planned) {
  if (planned.plan.outcome != grasp::PlanOutcome::kGraspable) {
    return grasp::in_words(planned.plan);
  }
  if (planned.arm && !planned.arm->motion.found()) return planned.arm->motion.problem;
  if (planned.arm) {
    const grasp::Grasp& taken = planned.plan.grasps[static_cast<std::size_t>(planned.arm->grasp)];
    return fmt::format(
        "The arm takes grasp {} (score {:.2f}, {}): the best that it can execute, or within {:.2f} "
        "of it.",
        planned.arm->grasp + 1, taken.score,
        taken.robustness < 0
            ? std::string(grasp::kNotAssessed)
            : fmt::format("held in {:.0f} % of the disturbed trials", 100 * taken.robustness),
        motion::PickOptions().success_for_path);
  }
  return fmt::format("{} grasps", planned.plan.grasps.size());
}

bool succeeded(const Planned& planned) {
  return planned.plan.outcome == grasp::PlanOutcome::kGraspable &&
         (!planned.arm || planned.arm->motion.found());
}

// What was assumed, and where the grasps come from.
std::vector<std::string> notes_of(const PlanChoices& choices, const PlanTarget& target,
                                  const Planned& planned) {
  std::vector<std::string> notes = target.notes;
  const robot::RobotModel& robot = planned.platform ? planned.platform->model : planned.hand.model;
  notes.insert(notes.end(), robot.remarks.begin(), robot.remarks.end());
  if (!planned.chosen.empty()) {
    notes.push_back((choices.tolerance > 0 ? "by the tolerance: " : "by the budget: ") +
                    planned.chosen);
  }
  if (!choices.path_planner.empty()) {
    notes.push_back("the arm's paths are found by " + choices.path_planner);
  }
  if (!choices.collision_checker.empty()) {
    notes.push_back("what the arm touches is tested by " + choices.collision_checker);
  }
  if (!choices.database.empty()) {
    const int stored = planned.remembered.stored;
    notes.push_back(!target.known ? "the object is not known: the database is not used"
                    : planned.remembered.reused
                        ? fmt::format("grasps from {} of {}", stored, choices.database)
                    : stored == 0 ? "added to " + choices.database
                                  : fmt::format("none of {} grasps of {} serves here: planned anew",
                                                stored, choices.database));
  }
  return notes;
}

Json choices_json(const std::vector<planning::Choice>& choices) {
  Json list = Json::array();
  for (const planning::Choice& choice : choices) {
    list.add(Json::object()
                 .set("act", planning::to_string(choice.act))
                 .set("grasp", choice.grasp)
                 .set("success", choice.success)
                 .set("worth_s", choice.worth)
                 .set("text", choice.text));
  }
  return list;
}

Json remedies_json(const planning::Remedies& remedies) {
  Json found = Json::array(), in_vain = Json::array();
  for (const planning::Remedy& remedy : remedies.found) {
    Json amounts = Json::array();
    for (const auto& amount : remedy.amounts) {
      amounts.add(Json::object()
                      .set("change", planning::to_string(amount.change))
                      .set("planned", amount.planned)
                      .set("needed", amount.needed));
    }
    found.add(Json::object()
                  .set("text", remedy.text)
                  .set("grasps", remedy.grasps)
                  .set("amounts", amounts));
  }
  for (const auto& one : remedies.in_vain) in_vain.add(one);
  return Json::object()
      .set("found", found)
      .set("in_vain", in_vain)
      .set("complete", remedies.complete);
}

Json json_of(const PlanChoices& choices, const PlanTarget& target, const Planned& planned) {
  Json grasps = Json::array(), ledger = Json::array(), times = Json::object();
  for (const grasp::Grasp& g : planned.plan.grasps) {
    const Eigen::Quaterniond q(g.X_WG.linear());
    const Eigen::Vector3d& p = g.X_WG.translation();
    Json position = Json::array(), orientation = Json::array(), approach = Json::array(),
         joints = Json::array();
    for (int k = 0; k < 3; ++k) position.add(p[k]);
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) orientation.add(value);
    for (int k = 0; k < 3; ++k) approach.add(g.approach_W[k]);
    for (Eigen::Index k = 0; k < g.closed_all.size(); ++k) joints.add(g.closed_all[k]);
    grasps.add(Json::object()
                   .set("score", g.score)
                   .set("quality", g.quality)
                   .set("robustness", g.robustness < 0 ? Json::null() : Json(g.robustness))
                   .set("effort", g.effort)
                   .set("preshape", g.preshape)
                   .set("position_m", position)
                   .set("orientation_wxyz", orientation)
                   .set("approach_direction", approach)
                   .set("closed_joints", joints)
                   .set("generator", g.generator)
                   .set("remark", remark_of(g)));
  }
  for (const auto& r : planned.plan.rejections) {
    ledger.add(Json::object()
                   .set("reason", to_string(r.reason))
                   .set("generator", r.generator)
                   .set("count", r.count)
                   .set("nearest_miss", r.nearest_miss));
  }
  for (const auto& [name, seconds] : all_times(target, planned)) times.set(name, seconds);
  Json notes = Json::array();
  for (const auto& note : notes_of(choices, target, planned)) notes.add(note);
  Json result = Json::object();
  const auto [size, deviation] = surface::predicted_size(target.object, target.table_W);
  result.set("size_m", Json::array().add(size.x()).add(size.y()).add(size.z()))
      .set("size_deviation_m",
           Json::array().add(deviation.x()).add(deviation.y()).add(deviation.z()))
      .set("candidates", planned.plan.candidates)
      .set("notes", notes)
      .set("problem", succeeded(planned) ? std::string() : verdict(planned))
      .set("grasps", grasps)
      .set("ledger", ledger)
      .set("choices", choices_json(planned.choices))
      .set("remedies", remedies_json(planned.remedies))
      .set("seconds", times);
  if (target.chain) result.set("chosen", chain_json(*target.chain));
  if (planned.arm) {
    Json arm = Json::object(), segments = Json::array(), missed = Json::array();
    for (const auto& segment : planned.arm->motion.segments) {
      segments.add(Json::object()
                       .set("name", motion::to_string(segment.kind))
                       .set("waypoints", segment.waypoints.size())
                       .set("duration_s", segment.trajectory ? Json(segment.trajectory->duration())
                                                             : Json::null()));
    }
    for (const auto& r : planned.arm->motion.rejections) {
      missed.add(Json::object()
                     .set("reason", motion::to_string(r.filter))
                     .set("count", r.count)
                     .set("nearest_miss", r.nearest_miss));
    }
    result.set(
        "arm",
        arm.set("grasp", planned.arm->grasp).set("segments", segments).set("ledger", missed));
  }
  return result;
}

// Object, hand and, where the arm reaches the grasp, the arm.
std::vector<report::ColoredMesh> scene_of(const PlanTarget& target, const Planned& planned,
                                          std::size_t index) {
  const grasp::Grasp& grasp = planned.plan.grasps[index];
  std::vector<report::ColoredMesh> meshes{{target.object.mesh_W, {214, 164, 86}}};
  for (const auto& pieces : target.neighbours_W) {
    meshes.push_back({geometry::concatenated(pieces), {190, 190, 190}});
  }
  meshes.push_back(
      {geometry::transformed(report::robot_mesh(planned.hand.model, grasp.closed_all), grasp.X_WH),
       {88, 122, 168}});
  return meshes;
}

report::ColoredMesh arm_mesh(const Planned& planned) {
  const robot::Platform& platform = *planned.platform;
  const robot::KinematicChain chain = platform.arm_chain();
  // The second segment is the straight approach: the arm at its end holds the hand at the grasp.
  const auto& segments = planned.arm->motion.segments;
  const robot::Positions q =
      segments[std::min<std::size_t>(1, segments.size() - 1)].waypoints.back();
  Eigen::VectorXd positions =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(platform.model.joints.size()));
  for (int k = 0; k < chain.size(); ++k) {
    positions[platform.model.joint_index(chain.joints()[static_cast<std::size_t>(k)].name)] = q[k];
  }
  const Eigen::VectorXd& hand =
      planned.plan.grasps[static_cast<std::size_t>(planned.arm->grasp)].closed_all;
  for (std::size_t k = 0; k < planned.hand.model.joints.size(); ++k) {
    positions[platform.model.joint_index("hand_" + planned.hand.model.joints[k].name)] =
        hand[static_cast<Eigen::Index>(k)];
  }
  return {geometry::transformed(report::robot_mesh(platform.model, positions), platform.X_WB),
          {88, 122, 168}};
}

geometry::ColorImage picture(const std::vector<report::ColoredMesh>& meshes, double azimuth) {
  constexpr int kWidth = 480, kHeight = 360;
  Eigen::AlignedBox3d box;
  for (const auto& mesh : meshes) box.extend(geometry::bounds(mesh.mesh_W));
  const auto camera = report::picture_camera(kWidth, kHeight);
  return draw_meshes(meshes, camera,
                     report::orbit(box.center(), box.diagonal().norm() / 2, azimuth, 0.35));
}

}  // namespace

void print_plan(const PlanChoices& choices, const PlanTarget& target, const Planned& planned) {
  if (choices.json) return tools::print(json_of(choices, target, planned));
  for (const auto& note : notes_of(choices, target, planned))
    std::printf("note: %s\n", note.c_str());
  print_rows(kGraspHeader, grasp_rows(choices, planned));
  print_rows(kLedgerHeader, ledger_rows(planned));
  if (planned.arm) {
    print_rows(kArmLedgerHeader, arm_ledger_rows(planned));
    print_rows(kSegmentHeader, segment_rows(planned));
  }
  print_rows(kChoiceHeader, choice_rows(planned));
  print_rows(kRemedyHeader, remedy_rows(planned));
  print_rows(kTimeHeader, time_rows(target, planned));
  std::printf("%s\n", verdict(planned).c_str());
}

void write_plan_page(const PlanChoices& choices, const PlanTarget& target, const Planned& planned) {
  report::Page page("Grasps of " + std::filesystem::path(choices.file).filename().string());
  if (succeeded(planned)) {
    page.add_verdict(verdict(planned), true);
  } else {
    page.add_answer(verdict(planned));
  }
  for (const auto& note : notes_of(choices, target, planned)) page.add_paragraph(note);
  if (planned.arm && planned.arm->motion.found()) {
    std::vector<report::ColoredMesh> meshes{{target.object.mesh_W, {214, 164, 86}},
                                            arm_mesh(planned)};
    page.add_pictures({picture(meshes, 0.7), picture(meshes, 2.2)},
                      {"The arm at the grasp", "from another side"});
  }
  std::vector<geometry::ColorImage> pictures;
  std::vector<std::string> captions;
  for (std::size_t i = 0; i < std::min(kPictures, planned.plan.grasps.size()); ++i) {
    pictures.push_back(picture(scene_of(target, planned, i), 0.7));
    captions.push_back(fmt::format("{}: score {:.3f} {}", i + 1, planned.plan.grasps[i].score,
                                   planned.plan.grasps[i].preshape));
  }
  if (pictures.empty()) {
    pictures.push_back(picture({{target.object.mesh_W, {214, 164, 86}}}, 0.7));
    captions.emplace_back("The object");
  }
  page.add_pictures(pictures, captions);
  page.add_heading("Grasps");
  page.add_table(kGraspHeader, grasp_rows(choices, planned));
  page.add_heading("Where the other candidates fell");
  report::add_rejections(page, fallen_candidates(planned), planned.plan.candidates, "candidates");
  if (const Rows rows = choice_rows(planned); !rows.empty()) {
    page.add_heading("What is worth most");
    page.add_table(kChoiceHeader, rows);
  }
  if (const Rows rows = remedy_rows(planned); !rows.empty()) {
    page.add_heading("What would help");
    page.add_table(kRemedyHeader, rows);
  }
  if (planned.arm) {
    page.add_heading("Arm");
    report::add_rejections(page, fallen_grasps(planned),
                           static_cast<int>(planned.plan.grasps.size()), "grasps");
    page.add_table(kSegmentHeader, segment_rows(planned));
  }
  if (target.chain) {
    page.add_heading("Speed and accuracy");
    report::add_front(page, drawn_front(*target.chain));
  }
  page.add_heading("Time");
  page.add_table(kTimeHeader, time_rows(target, planned));
  page.write(std::filesystem::path(choices.out) / "index.html");
}

void save_plan(const PlanChoices& choices, const PlanTarget& target, const Planned& planned) {
  const std::filesystem::path folder = choices.save;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (const char* name : {"object.ply", "object.obj", "object.stl"}) {
    geometry::write_mesh_file(folder / name, target.object.mesh_W);
  }
  const std::filesystem::path file = folder / "plan.json";
  std::ofstream stream(file);
  stream << json_of(choices, target, planned).pretty();
  stream.close();
  if (!stream) throw std::runtime_error("'" + file.string() + "' cannot be written");
}

}  // namespace prehend::tools
