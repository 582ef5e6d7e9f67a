#include "prehend/touch/touch_memory.h"

#include <algorithm>
#include <stdexcept>

namespace prehend::touch {
namespace {

void check_press(const RememberedPress& press) {
  if (press.features.size() == 0 || press.imprints.empty()) {
    throw std::invalid_argument("no pad touches anything: close the hand on the thing first");
  }
}

std::vector<Imprint> all_imprints(const std::vector<RememberedPress>& presses) {
  std::vector<Imprint> imprints;
  for (const RememberedPress& press : presses) {
    imprints.insert(imprints.end(), press.imprints.begin(), press.imprints.end());
  }
  return imprints;
}

std::vector<Eigen::VectorXd> all_features(const std::vector<RememberedPress>& presses) {
  std::vector<Eigen::VectorXd> features;
  for (const RememberedPress& press : presses) features.push_back(press.features);
  return features;
}

}  // namespace

RememberedPress remembered(const Eigen::VectorXd& posture, const std::vector<FeltFrame>& frames) {
  RememberedPress press{grasp_features(posture, frames), {}};
  for (const FeltFrame& frame : frames) {
    if (auto imprint = imprint_of(*frame.pad, felt_texels(*frame.pad, frame.counts))) {
      press.imprints.push_back(std::move(*imprint));
    }
  }
  return press;
}

void TouchMemory::teach(const std::string& name, const RememberedPress& press) {
  const bool printable =
      std::all_of(name.begin(), name.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (name.empty() || !printable || name.front() == ' ' || name.back() == ' ') {
    throw std::invalid_argument(
        "a thing's name must be printable ASCII that does not begin or end with a space");
  }
  check_press(press);
  for (const auto& [other, presses] : things_) {
    if (presses.front().features.size() != press.features.size()) {
      throw std::invalid_argument("'" + other + "' was taught with another hand: forget it first");
    }
  }
  things_[name].push_back(press);
  to_learn_.insert(name);
}

bool TouchMemory::forget(const std::string& name) {
  grasps_.forget(name);
  faces_.forget(name);
  to_learn_.erase(name);
  return things_.erase(name) > 0;
}

Recognised TouchMemory::ask(const std::vector<RememberedPress>& presses) {
  for (const RememberedPress& press : presses) check_press(press);
  for (const std::string& name : to_learn_) {
    if (by_ == RecogniseBy::kGrasp) {
      grasps_.teach(name, all_features(things_.at(name)));
    } else {
      faces_.teach(name, all_imprints(things_.at(name)));
    }
  }
  to_learn_.clear();
  return by_ == RecogniseBy::kGrasp ? grasps_.ask(all_features(presses))
                                    : faces_.ask(all_imprints(presses));
}

}  // namespace prehend::touch
