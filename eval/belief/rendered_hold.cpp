#include "eval/belief/rendered_hold.h"

#include <cstdint>
#include <utility>

#include <Eigen/Geometry>

#include "eval/case_runner.h"
#include "prehend/simulation/stereo_renderer.h"

namespace prehend::eval {

using geometry::RigidTransform;

RigidTransform disturbance(double along, double turn, const Eigen::Vector3d& middle,
                           std::mt19937_64* random) {
  std::normal_distribution<double> unit;
  const auto vector = [&](double deviation) {
    const double x = deviation * unit(*random), y = deviation * unit(*random);
    return Eigen::Vector3d(x, y, deviation * unit(*random));
  };
  const Eigen::Vector3d way = vector(along), axis = vector(turn);
  RigidTransform X = RigidTransform::Identity();
  const double angle = axis.norm();
  if (angle > 0) X.linear() = Eigen::AngleAxisd(angle, axis / angle).toRotationMatrix();
  X.translation() = middle - X.linear() * middle + way;
  return X;
}

void add_links(const std::vector<geometry::TriangleMesh>& links_W, RenderedScene* rendered) {
  simulation::Texture metal;
  metal.color = {0.55, 0.55, 0.58};
  for (const geometry::TriangleMesh& link_W : links_W) {
    simulation::VisibleBody body;
    body.name = "link";
    body.mesh_B = std::make_shared<geometry::TriangleMesh>(link_W);
    body.texture = metal;
    body.height = geometry::bounds(link_W).sizes().z();
    rendered->bodies.push_back(std::move(body));
  }
}

geometry::DepthImage seen_hold(RenderedScene rendered,
                               std::shared_ptr<const geometry::TriangleMesh> mesh_B,
                               const RigidTransform& X_WB,
                               const std::vector<geometry::TriangleMesh>& links_W, int look) {
  rendered.bodies.resize(1);
  rendered.bodies.front().mesh_B = std::move(mesh_B);
  rendered.bodies.front().X_WB = X_WB;
  add_links(links_W, &rendered);
  simulation::RenderOptions render;
  render.threads = 1;
  return seen_depth(rendered, simulation::render_stereo(rendered.scene, rendered.bodies,
                                                        static_cast<std::uint32_t>(look), render));
}

}  // namespace prehend::eval
