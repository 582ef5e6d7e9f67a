#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/grasp_memory.h"
#include "prehend/touch/imprint_memory.h"

namespace prehend::touch {

/// What is remembered of one press or grasp.
struct RememberedPress {
  Eigen::VectorXd features;       // grasp_features()
  std::vector<Imprint> imprints;  // of each pad that touched
};

/// @param posture how the hand stands: the opening [m], or the positions of its motors [rad]
RememberedPress remembered(const Eigen::VectorXd& posture, const std::vector<FeltFrame>& frames);

enum class RecogniseBy {
  kGrasp,   // things by how they are to grasp: GraspMemory
  kImprint  // faces by the pattern that they leave on a pad: ImprintMemory
};

/// Things by name, with every press that was taught of them.
class TouchMemory {
 public:
  explicit TouchMemory(RecogniseBy by) : by_(by) {}

  /// One more press of the thing. @throws std::invalid_argument for a name that is empty or not
  /// printable ASCII, a press in which nothing touched, or of another hand than the others.
  void teach(const std::string& name, const RememberedPress& press);
  /// False when it was not known.
  bool forget(const std::string& name);
  /// Learns first what was taught since the last question: by imprint, a face of 12 presses takes
  /// about 0.5 s. @throws std::invalid_argument without presses, or for one in which nothing
  /// touched.
  Recognised ask(const std::vector<RememberedPress>& presses);

  const std::map<std::string, std::vector<RememberedPress>>& things() const { return things_; }

  /// @throws geometry::InputError when it cannot be written, or would be too long to be read.
  void save(const std::filesystem::path& file) const;
  /// @throws geometry::InputError "file:line: what is wrong" with the mend.
  static TouchMemory load(const std::filesystem::path& file, RecogniseBy by);

 private:
  RecogniseBy by_;
  std::map<std::string, std::vector<RememberedPress>> things_;
  std::set<std::string> to_learn_;
  GraspMemory grasps_;
  ImprintMemory faces_;
};

}  // namespace prehend::touch
