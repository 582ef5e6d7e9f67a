#include "prehend/motion/checker_registry.h"

#include "prehend/motion/bullet_checker.h"
#include "prehend/motion/fcl_checker.h"

namespace prehend::motion {
namespace {

CollisionChecker* no_checker() { return nullptr; }
CollisionChecker* create_fcl() { return std::make_unique<FclChecker>().release(); }
CollisionChecker* create_bullet() { return std::make_unique<BulletChecker>().release(); }

}  // namespace

CheckerRegistry::CheckerRegistry() : CheckerRegistry(text::plug_in_folders("checker")) {}

CheckerRegistry::CheckerRegistry(const std::vector<std::filesystem::path>& folders)
    : checkers_("checker", kCheckerInterface, folders,
                {{kDefaultChecker, no_checker}, {"fcl", create_fcl}, {"bullet", create_bullet}}) {}

std::shared_ptr<const CollisionChecker> CheckerRegistry::create(const std::string& name) const {
  return std::shared_ptr<const CollisionChecker>(checkers_.find(name)());
}

}  // namespace prehend::motion
