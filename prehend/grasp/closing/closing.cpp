#include "prehend/grasp/closing/closing.h"

#include "prehend/grasp/closing/finger_closing.h"
#include "prehend/grasp/closing/pad_closing.h"

namespace prehend::grasp {

std::unique_ptr<Closing> make_closing(Solid solid, const geometry::Plane& table,
                                      const Obstacles& obstacles, const HandToClose& hand,
                                      const Reachability& reachability,
                                      const PlannerOptions& options) {
  if (hand.hand->gripper) {
    return std::make_unique<PadClosing>(std::move(solid), table, obstacles, *hand.hand,
                                        reachability, options);
  }
  return std::make_unique<FingerClosing>(std::move(solid), table, obstacles, hand, reachability,
                                         options);
}

}  // namespace prehend::grasp
