#include "prehend/report/film.h"

#include <cmath>

#include "prehend/report/figure_data.h"
#include "prehend/text/json.h"
#include "prehend/text/require.h"

namespace prehend::report {
namespace {

using text::Json;

std::string poses_of(const std::vector<geometry::RigidTransform>& poses) {
  std::vector<float> numbers;
  for (const geometry::RigidTransform& X : poses) {
    const Eigen::Quaterniond q(X.linear());
    for (int k = 0; k < 3; ++k) numbers.push_back(static_cast<float>(X.translation()[k]));
    for (const double part : {q.w(), q.x(), q.y(), q.z()}) {
      numbers.push_back(static_cast<float>(part));
    }
  }
  return packed(numbers);
}

void check(const Film& film) {
  const text::Require require{"Film: "};
  require(!film.times.empty() && !film.bodies.empty(), "there must be frames and bodies");
  require(film.captions.size() == film.times.size(), "each frame needs a caption");
  for (std::size_t i = 0; i < film.times.size(); ++i) {
    require(std::isfinite(film.times[i]) && (i == 0 || film.times[i] > film.times[i - 1]),
            "times must increase");
  }
  for (const FilmBody& body : film.bodies) {
    const std::string name = "body '" + body.name + "': ";
    require(body.X_WB.size() == 1 || body.X_WB.size() == film.times.size(),
            name + "it needs one pose, or one for each frame");
    require(body.opacity > 0 && body.opacity <= 1, name + "opacity must be above 0, at most 1");
    for (const auto& X : body.X_WB) require(X.matrix().allFinite(), name + "a pose is not finite");
  }
}

}  // namespace

std::string film_json(const Film& film) {
  check(film);
  Json times = Json::array(), bodies = Json::array();
  for (const double time : film.times) times.add(time);
  for (const FilmBody& body : film.bodies) {
    Json one = Json::object();
    one.set("name", body.name);
    one.set("color", color_text(body.color));
    one.set("opacity", body.opacity);
    set_mesh(one, body.mesh_B, "Film: body '" + body.name + "': ");
    one.set("poses", poses_of(body.X_WB));
    bodies.add(one);
  }
  Json all = Json::object();
  all.set("times", times);
  all.set("captions", Json(film.captions));
  all.set("bodies", bodies);
  return for_script(all);
}

}  // namespace prehend::report
