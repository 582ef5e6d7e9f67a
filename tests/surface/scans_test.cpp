// Views of real scans: what completion and meshing make of shapes that are not solids of a
// textbook.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/deviation.h"
#include "prehend/surface/model.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::surface {
namespace {

TEST(Scans, AreCompletedFromOneView) {
  const char* folder = std::getenv("PREHEND_SHARED_DATA");
  if (folder == nullptr || *folder == '\0') {
    GTEST_SKIP() << "PREHEND_SHARED_DATA is not set: no scans to look at";
  }
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(folder) / "meshes" / "ycb")) {
    if (entry.path().extension() == ".ply") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());

  std::printf("%-24s %4s %6s %6s | %5s %5s %5s | %5s %5s %5s | %6s %5s %6s | %s\n", "scan", "yaw",
              "vote", "planes", "mean", "95 %", "max", "mean", "95 %", "max", "volume", "seen",
              "pieces", "seconds: completion normals poisson pieces");
  for (const auto& file : files) {
    const geometry::TriangleMesh scan = geometry::read_mesh_file(file);
    for (const double yaw : {0.0, 0.6, 1.2}) {
      const geometry::TriangleMesh truth = shape::standing(scan, yaw);
      const shape::SyntheticView view =
          shape::synthetic_view(truth, {.distance = 0.8, .depth_noise = 0.0005});
      const auto start = std::chrono::steady_clock::now();
      const shape::CompletedShape completed = shape::complete_by_symmetry(view.view());
      const double seconds =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      ModelTimes times;
      const ObjectModel model = make_object_model(completed, view.table_W, {}, &times);
      const MeshDeviation d = mesh_deviation(model.mesh_W, truth);
      std::printf(
          "%-24s %4.1f %6.3f %6d | %5.1f %5.1f %5.1f | %5.1f %5.1f %5.1f | %6.2f %5.2f %6zu "
          "| %.2f %.2f %.2f %.2f\n",
          file.stem().c_str(), yaw, completed.symmetry.vote,
          1 + completed.second_symmetry.has_value(), d.to_second.mean * 1e3,
          d.to_second.percentile_95 * 1e3, d.to_second.max * 1e3, d.from_second.mean * 1e3,
          d.from_second.percentile_95 * 1e3, d.from_second.max * 1e3,
          model.mass_properties.volume / geometry::mass_properties(truth).volume,
          model.seen_deviation * 1e3, model.convex_pieces_W.size(), seconds, times.normals,
          times.poisson, times.convex_pieces);
      EXPECT_TRUE(model.defects.watertight()) << file;
      EXPECT_LT(model.seen_deviation, 0.0025) << file;
      EXPECT_LT(d.to_second.mean, 0.015) << file;
      EXPECT_GE(geometry::bounds(model.mesh_W).min().z(), -1e-9) << file;
    }
  }
}

}  // namespace
}  // namespace prehend::surface
