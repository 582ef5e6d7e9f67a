#include <algorithm>
#include <map>
#include <utility>

#include "eval/belief/toucher.h"
#include "eval/grasp/in_reach.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/planner.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/robot/robot_files.h"
#include "prehend/surface/model.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {
namespace {

constexpr int kRobust = 8;            // grasps that are tried in disturbed poses
constexpr double kTouchable = 0.002;  // m over it: what is touched lower is no part of the object

/// What contacts where the grasp's fingers are expected would tell, see
/// ObjectBelief::expected_gain(): of each link's contacts their mean.
double gain_of(const grasp::Grasp& grasp, const belief::ObjectBelief& belief,
               const std::vector<belief::ObjectBelief::Site>& sites, double deviation) {
  std::map<int, std::pair<Eigen::Vector3d, int>> by_link;
  for (const grasp::GraspContact& contact : grasp.contacts) {
    auto& [sum, count] =
        by_link.try_emplace(contact.link, Eigen::Vector3d::Zero(), 0).first->second;
    sum += contact.contact_W.point;
    ++count;
  }
  double gain = 0;
  for (const auto& [link, mean] : by_link) {
    const Eigen::Vector3d p = mean.first / mean.second;
    const auto nearest =
        std::min_element(sites.begin(), sites.end(), [&](const auto& a, const auto& b) {
          return (a.p_W - p).squaredNorm() < (b.p_W - p).squaredNorm();
        });
    if (nearest != sites.end()) gain += belief.expected_gain(*nearest, deviation);
  }
  return gain;
}

bool is_near(const geometry::RigidTransform& a, const geometry::RigidTransform& b) {
  constexpr double kNear = 0.01, kTurn = 0.3;  // m, rad
  return (a.translation() - b.translation()).norm() < kNear &&
         Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() < kTurn;
}

}  // namespace

TouchingHand::TouchingHand(const std::string& name) {
  const std::filesystem::path robots = text::tree_file("config/robots");
  const std::vector<std::string> platforms = robot::platform_names(robots);
  if (std::find(platforms.begin(), platforms.end(), name) != platforms.end()) {
    const robot::Platform platform =
        in_reach(robot::read_platform(robot::platform_file(robots, name)));
    model_ = platform.hand;
    options_ = planning::within_reach(grasp::default_options(model_), platform);
    reachability_ = planning::within_reach(grasp::Reachability{}, platform);
  } else {
    model_ = robot::read_hand_model(robot::hand_file(robots, name));
    options_ = grasp::default_options(model_);
  }
  if (model_.pads.empty()) {
    throw geometry::InputError("The hand '" + model_.name + "' has no tactile pads",
                               "Choose one that feels");
  }
  options_.threads = 1;
  options_.robust_count = kRobust;
  to_close_ = std::make_unique<grasp::HandToClose>(model_);
  evidence_ = std::make_unique<belief::HandEvidence>(model_);
}

std::vector<grasp::Grasp> TouchingHand::grasps(const belief::ObjectBelief& belief) const {
  return grasp::plan_grasps(surface::model_of_mesh(belief.mesh()), belief.table_W(), {}, *to_close_,
                            reachability_, options_)
      .grasps;
}

const grasp::Grasp* HandToucher::chosen(const std::vector<grasp::Grasp>& grasps,
                                        const belief::ObjectBelief& belief) const {
  const std::vector<belief::ObjectBelief::Site> sites = belief.sites();
  const grasp::Grasp* best = nullptr;
  double most = -1;
  for (const grasp::Grasp& grasp : grasps) {
    if (std::any_of(touched_.begin(), touched_.end(),
                    [&](const auto& X_WH) { return is_near(X_WH, grasp.X_WH); })) {
      continue;
    }
    if (touched_.empty()) return &grasp;
    const double gain = gain_of(grasp, belief, sites, 0.001);
    if (gain <= most) continue;
    most = gain;
    best = &grasp;
  }
  return best;
}

std::string HandToucher::touch(const geometry::MeshQuery& truth_W, Told told,
                               belief::ObjectBelief* belief) {
  const std::vector<grasp::Grasp> grasps = hand_.grasps(*belief);
  if (grasps.empty()) return "no grasp of it is found";
  const grasp::Grasp* grasp = chosen(grasps, *belief);
  if (grasp == nullptr) return "all of its grasps were touched";
  touched_.push_back(grasp->X_WH);
  geometry::RigidTransform X_WH_start = grasp->X_WH;
  X_WH_start.translation() -= grasp->pregrasp_distance * grasp->approach_W;
  const robot::Preshape& preshape = hand_.model().preshape(grasp->preshape);
  HandClosing closing = close_hand(
      hand_.to_close(), robot::closing_way(hand_.model(), preshape, grasp->open, grasp->closed),
      X_WH_start, grasp->X_WH, &truth_W);
  std::normal_distribution<double> normal(0, noise_.place);
  const Eigen::Vector3d error(normal(random_), normal(random_), normal(random_));
  for (belief::HandSample& sample : closing.way) sample.X_WH.translation() += error;

  belief->begin_act();
  for (const belief::Contact& contact :
       hand_.evidence().contacts(closing.way.back(), closing.frames)) {
    if (belief->table_W().signed_distance(contact.p_W) > kTouchable) belief->add(contact);
  }
  if (told == Told::kEmpty) {
    hand_.evidence().sweep(closing.way, hand_.evidence().depths(closing.frames), &belief->swept());
  }
  return "";
}

}  // namespace prehend::eval
