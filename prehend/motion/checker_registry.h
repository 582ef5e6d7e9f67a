#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prehend/motion/collision_checker.h"
#include "prehend/text/plug_ins.h"

namespace prehend::motion {

inline constexpr const char* kDefaultChecker = "balls";

/// Collision checkers by name: `balls` (the default: RobotInWorld's own), `fcl`, `bullet`, and each
/// plug-in in the folders of PREHEND_CHECKERS and in ../lib/prehend/checkers beside the
/// running program (text::plug_in_folders()).
class CheckerRegistry {
 public:
  CheckerRegistry();
  explicit CheckerRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const { return checkers_.names(); }  // sorted
  /// For RobotInWorld::use_checker(): null for `balls`.
  /// @throws std::invalid_argument naming the nearest and all that there are.
  std::shared_ptr<const CollisionChecker> create(const std::string& name) const;
  const std::vector<text::PlugInProblem>& problems() const { return checkers_.problems(); }

 private:
  text::NamedPlugIns<CollisionChecker> checkers_;
};

}  // namespace prehend::motion
