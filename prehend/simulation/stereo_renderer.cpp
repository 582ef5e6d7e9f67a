#include "prehend/simulation/stereo_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <thread>

#include <embree3/rtcore.h>

namespace prehend::simulation {
namespace {

constexpr std::int16_t kTableLabel = -1;
constexpr std::int16_t kNothingLabel = -2;
const Eigen::Vector3d kBackground(0.32, 0.34, 0.37);

struct SceneRelease {
  void operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }
};

RTCDevice shared_device() {
  static RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
  if (device == nullptr) throw std::runtime_error("Embree could not create a device");
  return device;
}

// A mesh of the world frame in Embree's scene; its geometry id is the number of calls before.
void attach(RTCScene scene, const geometry::TriangleMesh& mesh,
            const geometry::RigidTransform& X_WB) {
  RTCGeometry geometry = rtcNewGeometry(shared_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d p = X_WB * mesh.vertices[i];
    for (int k = 0; k < 3; ++k) vertices[3 * i + k] = static_cast<float>(p[k]);
  }
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) indices[3 * i + k] = static_cast<unsigned>(mesh.triangles[i][k]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

std::uint32_t mixed(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x85EBCA6Bu;
  h ^= h >> 13;
  h *= 0xC2B2AE35u;
  return h ^ h >> 16;
}

// Two Gaussian numbers of a pixel (Box-Muller), the same in whatever order pixels are made.
Eigen::Vector2d gaussian_pair(std::uint32_t seed, std::uint32_t index) {
  const std::uint32_t a = mixed(index * 2 + mixed(seed)), b = mixed(index * 2 + 1 + mixed(seed));
  const double u = (a + 1.0) / 4294967297.0, angle = 2 * std::numbers::pi * b / 4294967296.0;
  const double radius = std::sqrt(-2 * std::log(u));
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

class RayTracer {
 public:
  RayTracer(const Scene& scene, const std::vector<VisibleBody>& bodies,
            const RenderOptions& options)
      : scene_(scene),
        bodies_(bodies),
        options_(options),
        embree_(rtcNewScene(shared_device())),
        light_(scene.light.direction.normalized()) {
    for (const VisibleBody& body : bodies) {
      attach(embree_.get(), *body.mesh_B, body.X_WB);
      X_BW_.push_back(body.X_WB.inverse());
    }
    geometry::TriangleMesh table;
    const Eigen::Vector2d low = scene.table.center - 0.5 * scene.table.size;
    const Eigen::Vector2d high = scene.table.center + 0.5 * scene.table.size;
    table.vertices = {{low.x(), low.y(), 0},
                      {high.x(), low.y(), 0},
                      {high.x(), high.y(), 0},
                      {low.x(), high.y(), 0}};
    table.triangles = {{0, 1, 2}, {0, 2, 3}};
    attach(embree_.get(), table, geometry::RigidTransform::Identity());
    rtcCommitScene(embree_.get());
  }

  struct Sample {
    Eigen::Vector3d color = kBackground;
    double distance = std::numeric_limits<double>::quiet_NaN();  // m, along the ray
    std::int16_t label = kNothingLabel;
  };

  Sample trace(const Eigen::Vector3d& eye, const Eigen::Vector3d& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    RTCRayHit ray{};
    set_ray(ray.ray, eye, direction);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(embree_.get(), &context, &ray);
    Sample sample;
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return sample;
    sample.distance = ray.ray.tfar;
    const bool is_table = ray.hit.geomID == bodies_.size();
    sample.label = is_table ? kTableLabel : static_cast<std::int16_t>(ray.hit.geomID);
    const Eigen::Vector3d p_W = eye + sample.distance * direction;
    Eigen::Vector3d normal(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z);
    normal.normalize();
    if (normal.dot(direction) > 0) normal = -normal;
    const Eigen::Vector3d base =
        is_table ? texture_color(scene_.table.texture, p_W, 1)
                 : texture_color(bodies_[ray.hit.geomID].texture, X_BW_[ray.hit.geomID] * p_W,
                                 bodies_[ray.hit.geomID].height);
    double lit = std::max(0.0, normal.dot(light_));
    if (options_.shadows && lit > 0 && in_shadow(p_W + 1e-4 * normal)) lit = 0;
    // A little of the ambient light comes from above only, so that faces differ in the shadow, too.
    const double ambient = scene_.light.ambient * (0.8 + 0.2 * normal.z());
    sample.color = base * (ambient + (1 - scene_.light.ambient) * lit);
    return sample;
  }

 private:
  static void set_ray(RTCRay& ray, const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& direction) {
    ray.org_x = static_cast<float>(origin.x());
    ray.org_y = static_cast<float>(origin.y());
    ray.org_z = static_cast<float>(origin.z());
    ray.dir_x = static_cast<float>(direction.x());
    ray.dir_y = static_cast<float>(direction.y());
    ray.dir_z = static_cast<float>(direction.z());
    ray.tnear = 0;
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0u;
  }

  bool in_shadow(const Eigen::Vector3d& point) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray{};
    set_ray(ray, point, light_);
    rtcOccluded1(embree_.get(), &context, &ray);
    return ray.tfar < 0;
  }

  const Scene& scene_;
  const std::vector<VisibleBody>& bodies_;
  RenderOptions options_;
  std::unique_ptr<RTCSceneTy, SceneRelease> embree_;
  Eigen::Vector3d light_;
  std::vector<geometry::RigidTransform> X_BW_;
};

// One camera's image; depth and labels only where asked for.
struct Target {
  geometry::RigidTransform X_WC;
  std::uint32_t noise_seed = 0;
  geometry::ColorImage* color = nullptr;
  geometry::DepthImage* depth = nullptr;
  geometry::Image<std::int16_t>* labels = nullptr;
};

void render_row(const RayTracer& tracer, const CameraSetup& setup, const RenderOptions& options,
                const Target& target, int v) {
  const geometry::PinholeCamera& camera = setup.camera.left;
  const int n = options.samples_per_side;
  const Eigen::Vector3d eye = target.X_WC.translation();
  for (int u = 0; u < camera.width; ++u) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int s = 0; s < n * n; ++s) {
      const double du = (s % n + 0.5) / n - 0.5, dv = (s / n + 0.5) / n - 0.5;
      const Eigen::Vector3d ray_C = camera.unproject(u + du, v + dv, 1.0);
      const double length = ray_C.norm();
      const auto sample = tracer.trace(eye, target.X_WC.linear() * (ray_C / length));
      sum += sample.color;
      // The sample nearest to the pixel's centre stands for depth and label.
      if (s != (n * n) / 2) continue;
      if (target.depth) target.depth->at(u, v) = static_cast<float>(sample.distance / length);
      if (target.labels) target.labels->at(u, v) = sample.label;
    }
    const auto pixel = static_cast<std::uint32_t>(v * camera.width + u);
    const Eigen::Vector2d first = gaussian_pair(target.noise_seed, 2 * pixel);
    const Eigen::Vector2d second = gaussian_pair(target.noise_seed, 2 * pixel + 1);
    const Eigen::Vector3d noise(first.x(), first.y(), second.x());
    const Eigen::Vector3d grey = 255.0 / (n * n) * sum + setup.noise * noise;
    for (int k = 0; k < 3; ++k) {
      target.color->at(u, v)[k] =
          static_cast<std::uint8_t>(std::clamp(std::round(grey[k]), 0.0, 255.0));
    }
  }
}

void check(const Scene& scene, const RenderOptions& options) {
  if (options.samples_per_side < 1 || options.samples_per_side > 4) {
    throw std::invalid_argument("RenderOptions::samples_per_side must be from 1 to 4");
  }
  if (options.threads < 1 || options.threads > 64) {
    throw std::invalid_argument("RenderOptions::threads must be from 1 to 64");
  }
  validate(scene);
}

}  // namespace

StereoImages render_stereo(const Scene& scene, const std::vector<VisibleBody>& bodies,
                           std::uint32_t frame, const RenderOptions& options) {
  check(scene, options);
  const RayTracer tracer(scene, bodies, options);
  const geometry::PinholeCamera& camera = scene.camera.camera.left;
  StereoImages images;
  images.left = images.right = geometry::ColorImage(camera.width, camera.height);
  images.depth = geometry::DepthImage(camera.width, camera.height);
  images.labels = geometry::Image<std::int16_t>(camera.width, camera.height);

  Target left{scene.camera.X_WC(), mixed(scene.camera.seed) + 2 * frame, &images.left,
              &images.depth, &images.labels};
  Target right = left;
  right.X_WC.translation() += scene.camera.camera.baseline * left.X_WC.linear().col(0);
  right.noise_seed += 1;
  right.color = &images.right;
  right.depth = nullptr;
  right.labels = nullptr;

  const auto render_every = [&](int first) {
    for (int v = first; v < camera.height; v += options.threads) {
      render_row(tracer, scene.camera, options, left, v);
      render_row(tracer, scene.camera, options, right, v);
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < options.threads; ++i) others.emplace_back(render_every, i);
  render_every(0);
  for (std::thread& thread : others) thread.join();
  return images;
}

}  // namespace prehend::simulation
