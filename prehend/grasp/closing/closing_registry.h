#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prehend/grasp/closing/closing.h"
#include "prehend/text/plug_ins.h"

namespace prehend::grasp {

/// Methods of closing by name: "pads" (pad_closing.h: of a parallel gripper with pads), "fingers"
/// (finger_closing.h: of every other hand), and each plug-in in the folders of PREHEND_CLOSINGS and
/// in ../lib/prehend/closings beside the running program (text::plug_in_folders()).
class ClosingRegistry {
 public:
  ClosingRegistry();
  explicit ClosingRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const { return methods_.names(); }  // sorted
  /// Closings of a plug-in's method are held to what they promise: evaluate() and refine() throw
  /// std::runtime_error, naming it, for a grasp that is not of the hand.
  /// @throws std::invalid_argument naming the nearest and all that there are.
  std::shared_ptr<const ClosingMethod> create(const std::string& name) const;
  const std::vector<text::PlugInProblem>& problems() const { return methods_.problems(); }

 private:
  text::NamedPlugIns<ClosingMethod> methods_;
};

/// The method of this hand: HandModel::closing_method(). For what is built in it looks at no
/// folder.
/// @throws geometry::InputError naming the hand: there is none of that name (with the nearest), or
/// the hand cannot close so.
std::shared_ptr<const ClosingMethod> closing_method(const robot::HandModel& hand);

/// The hand's closing on the task's solid.
std::unique_ptr<Closing> make_closing(const ClosingTask& task);

}  // namespace prehend::grasp
