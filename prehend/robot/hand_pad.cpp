#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "prehend/robot/hand_model.h"

namespace prehend::robot {
namespace {

constexpr double kFacing = 0.7;  // cosine, of what presses on a face

}  // namespace

double HandPad::length() const {
  if (model.texel_pitch > 0) return model.length();
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t i = 0; i < layout->size(); ++i) {
    least = std::min(least, layout->y[i]);
    most = std::max(most, layout->y[i]);
  }
  return most - least;
}

bool HandPad::covers(const Eigen::Vector3d& p_P, const Eigen::Vector3d& normal_P) const {
  if (layout->is_flat()) {
    return std::abs(p_P.x()) <= model.width() / 2 && std::abs(p_P.y()) <= model.length() / 2 &&
           normal_P.z() > kFacing;
  }
  for (std::size_t i = 0; i < layout->size(); ++i) {
    const double side_squared = layout->area(i);
    if ((p_P - layout->position(i)).squaredNorm() < side_squared &&
        normal_P.dot(layout->normal(i)) > kFacing) {
      return true;
    }
  }
  return false;
}

HandPad flat_pad(std::string name, int link, const geometry::RigidTransform& X_LP,
                 const TactilePadModel& model) {
  const contact::PadGrid grid{model.rows, model.columns, model.width(), model.length(),
                              model.thickness};
  return {std::move(name), link, X_LP, model,
          std::make_shared<const contact::PadLayout>(contact::PadLayout::flat(grid))};
}

}  // namespace prehend::robot
