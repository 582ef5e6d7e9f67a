#include "prehend/report/pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/geometry/mesh_query.h"

namespace prehend::report {
namespace {

using geometry::ColorImage;
using geometry::Rgb;

constexpr Rgb kWhite{255, 255, 255};

Rgb scaled(const Rgb& color, double factor) {
  Rgb out;
  for (int k = 0; k < 3; ++k) {
    out[k] = static_cast<std::uint8_t>(std::clamp(color[k] * factor, 0.0, 255.0));
  }
  return out;
}

Rgb mixed(const Rgb& a, const Rgb& b, double part_of_b) {
  Rgb out;
  for (int k = 0; k < 3; ++k) {
    out[k] = static_cast<std::uint8_t>(a[k] * (1 - part_of_b) + b[k] * part_of_b);
  }
  return out;
}

// The 256 colours of one of OpenCV's maps, as red-green-blue.
std::vector<Rgb> color_map(int opencv_map) {
  cv::Mat ramp(1, 256, CV_8UC1), colors;
  for (int i = 0; i < 256; ++i) ramp.at<std::uint8_t>(0, i) = static_cast<std::uint8_t>(i);
  cv::applyColorMap(ramp, colors, opencv_map);
  std::vector<Rgb> out;
  for (int i = 0; i < 256; ++i) {
    const auto bgr = colors.at<cv::Vec3b>(0, i);
    out.push_back({bgr[2], bgr[1], bgr[0]});
  }
  return out;
}

}  // namespace

Rgb category_color(int index) {
  static constexpr Rgb kColors[] = {{228, 88, 60},  {56, 134, 200}, {90, 170, 80},  {150, 96, 180},
                                    {240, 160, 40}, {60, 180, 180}, {200, 90, 150}, {140, 110, 80}};
  return kColors[static_cast<unsigned>(index) % std::size(kColors)];
}

ColorImage color_values(const geometry::Image<float>& values) {
  ColorImage out(values.width, values.height, {0, 0, 0});
  std::vector<float> known;
  for (const float value : values.data) {
    if (std::isfinite(value)) known.push_back(value);
  }
  if (known.empty()) return out;
  const auto percentile = [&known](double part) {
    const auto n = static_cast<std::ptrdiff_t>(part * static_cast<double>(known.size() - 1));
    std::nth_element(known.begin(), known.begin() + n, known.end());
    return known[n];
  };
  const float low = percentile(0.02), high = percentile(0.98);
  const float range = std::max(high - low, 1e-6f);
  const auto map = color_map(cv::COLORMAP_TURBO);
  for (std::size_t i = 0; i < values.data.size(); ++i) {
    if (!std::isfinite(values.data[i])) continue;
    const float part = std::clamp((values.data[i] - low) / range, 0.0f, 1.0f);
    out.data[i] = map[static_cast<std::size_t>(part * 255)];
  }
  return out;
}

ColorImage overlay_masks(const ColorImage& image, const std::vector<geometry::MaskImage>& masks) {
  ColorImage out = image;
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const auto& mask = masks[m];
    if (mask.width != image.width || mask.height != image.height) {
      throw std::invalid_argument("a mask must have its image's size");
    }
    const Rgb color = category_color(static_cast<int>(m));
    const auto inside = [&mask](int u, int v) { return mask.contains(u, v) && mask.at(u, v) != 0; };
    for (int v = 0; v < mask.height; ++v) {
      for (int u = 0; u < mask.width; ++u) {
        if (!inside(u, v)) continue;
        const bool border =
            !inside(u - 2, v) || !inside(u + 2, v) || !inside(u, v - 2) || !inside(u, v + 2);
        out.at(u, v) = mixed(image.at(u, v), color, border ? 1.0 : 0.4);
      }
    }
  }
  return out;
}

ColorImage draw_cloud(const geometry::PointCloud& cloud_W, const std::vector<Rgb>& colors,
                      const geometry::PinholeCamera& camera, const geometry::RigidTransform& X_WC,
                      int point_size) {
  if (colors.size() != cloud_W.size()) {
    throw std::invalid_argument("draw_cloud needs one colour for each point");
  }
  ColorImage out(camera.width, camera.height, kWhite);
  std::vector<double> nearest(out.data.size(), std::numeric_limits<double>::infinity());
  const geometry::RigidTransform X_CW = X_WC.inverse();
  for (std::size_t i = 0; i < cloud_W.size(); ++i) {
    if (!geometry::is_finite(cloud_W.points[i])) continue;
    const Eigen::Vector3d p_C = X_CW * cloud_W.points[i].cast<double>();
    if (!(p_C.z() > 1e-6)) continue;
    const Eigen::Vector2d pixel = camera.project(p_C);
    if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) continue;
    const int u0 = static_cast<int>(std::lround(pixel.x())) - point_size / 2;
    const int v0 = static_cast<int>(std::lround(pixel.y())) - point_size / 2;
    for (int v = v0; v < v0 + point_size; ++v) {
      for (int u = u0; u < u0 + point_size; ++u) {
        if (!out.contains(u, v)) continue;
        double& z = nearest[static_cast<std::size_t>(v) * out.width + u];
        if (p_C.z() >= z) continue;
        z = p_C.z();
        out.at(u, v) = colors[i];
      }
    }
  }
  return out;
}

ColorImage draw_meshes(const std::vector<ColoredMesh>& meshes,
                       const geometry::PinholeCamera& camera,
                       const geometry::RigidTransform& X_WC) {
  ColorImage out(camera.width, camera.height, kWhite);
  std::vector<geometry::TriangleMesh> parts;
  std::vector<Rgb> triangle_colors;
  for (const auto& part : meshes) {
    parts.push_back(part.mesh_W);
    triangle_colors.insert(triangle_colors.end(), part.mesh_W.triangles.size(), part.color);
  }
  geometry::TriangleMesh all = geometry::concatenated(parts);
  if (all.empty()) return out;
  const geometry::MeshQuery query(std::move(all));
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      const Eigen::Vector3d direction = X_WC.linear() * camera.unproject(u, v, 1).normalized();
      const auto hit = query.cast_ray(X_WC.translation(), direction);
      if (!hit) continue;
      const double facing = std::abs(hit->normal.dot(direction));
      out.at(u, v) = scaled(triangle_colors[hit->triangle], 0.3 + 0.75 * facing);
    }
  }
  return out;
}

namespace {

constexpr Rgb kNoCell{70, 70, 70};

Rgb heat(double value, double full) {
  static const auto map = color_map(cv::COLORMAP_HOT);
  const double part = full > 0 ? std::clamp(value / full, 0.0, 1.0) : 0.0;
  return map[static_cast<std::size_t>(part * 255)];
}

}  // namespace

ColorImage draw_cells(const std::vector<DrawnCell>& cells, double full, int longest) {
  Eigen::AlignedBox2d box;
  for (const DrawnCell& cell : cells) {
    if (!(std::isfinite(cell.side) && cell.side > 0 && cell.center.allFinite())) {
      throw std::invalid_argument("draw_cells: a cell has no size or no place");
    }
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * cell.side);
    box.extend(cell.center - half);
    box.extend(cell.center + half);
  }
  if (cells.empty() || longest < 2) throw std::invalid_argument("draw_cells: there is no cell");
  const double pixels = longest / box.sizes().maxCoeff();  // for a metre
  const auto size_of = [pixels](double length) {
    return std::max(1, static_cast<int>(std::lround(pixels * length)));
  };
  ColorImage out(size_of(box.sizes().x()), size_of(box.sizes().y()), kNoCell);
  for (const DrawnCell& cell : cells) {
    const Rgb color = heat(cell.value, full);
    const double left = pixels * (cell.center.x() - 0.5 * cell.side - box.min().x());
    const double top = pixels * (box.max().y() - cell.center.y() - 0.5 * cell.side);
    const int side = std::max(1, static_cast<int>(pixels * cell.side) - 1);
    const int u0 = static_cast<int>(std::lround(left)), v0 = static_cast<int>(std::lround(top));
    for (int v = std::max(0, v0); v < std::min(out.height, v0 + side); ++v) {
      for (int u = std::max(0, u0); u < std::min(out.width, u0 + side); ++u) out.at(u, v) = color;
    }
  }
  return out;
}

ColorImage draw_tactile(const std::vector<double>& values, int rows, int columns, double full,
                        int cell) {
  if (values.size() != static_cast<std::size_t>(rows) * columns || cell < 2) {
    throw std::invalid_argument("draw_tactile needs rows * columns values");
  }
  ColorImage out(columns * cell, rows * cell, kNoCell);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double value = values[static_cast<std::size_t>(r) * columns + c];
      const Rgb color = heat(value, full);
      for (int v = 0; v < cell - 1; ++v) {
        for (int u = 0; u < cell - 1; ++u) out.at(c * cell + u, r * cell + v) = color;
      }
    }
  }
  return out;
}

geometry::PinholeCamera picture_camera(int width, int height, double field_of_view) {
  const double f = width / 2.0 / std::tan(field_of_view / 2);
  return {width, height, f, f, (width - 1) / 2.0, (height - 1) / 2.0};
}

geometry::RigidTransform orbit(const Eigen::Vector3d& center_W, double radius, double azimuth,
                               double elevation, double field_of_view) {
  const double distance = 1.35 * radius / std::sin(field_of_view / 2);
  const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                  std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  return geometry::look_at(center_W + distance * direction, center_W);
}

std::string encode_png(const ColorImage& image) {
  if (image.empty()) throw std::runtime_error("an empty image cannot be written as PNG");
  const cv::Mat rgb(image.height, image.width, CV_8UC3,
                    const_cast<Rgb*>(image.data.data()));  // only read
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", bgr, bytes)) throw std::runtime_error("PNG encoding failed");
  return {bytes.begin(), bytes.end()};
}

}  // namespace prehend::report
