// Mesh deviation beside MeshLab's filter "Hausdorff Distance", an independent implementation.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/mesh_files.h"
#include "prehend/surface/deviation.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

constexpr const char* kScript = R"(<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Hausdorff Distance">
  <Param type="RichMesh" name="SampledMesh" value="0"/>
  <Param type="RichMesh" name="TargetMesh" value="1"/>
  <Param type="RichBool" name="SaveSample" value="false"/>
  <Param type="RichBool" name="SampleVert" value="false"/>
  <Param type="RichBool" name="SampleEdge" value="false"/>
  <Param type="RichBool" name="SampleFauxEdge" value="false"/>
  <Param type="RichBool" name="SampleFace" value="true"/>
  <Param type="RichInt" name="SampleNum" value="100000"/>
  <Param type="RichAbsPerc" name="MaxDist" value="100" min="0" max="100"/>
 </filter>
</FilterScript>
)";

/// A folder that goes with its contents.
class TemporaryFolder {
 public:
  TemporaryFolder()
      : path_(std::filesystem::temp_directory_path() /
              ("prehend_meshlab_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// The number after `name` and a colon in what MeshLab printed.
double number_after(const std::string& text, const std::string& name) {
  std::size_t at = text.find(name);
  EXPECT_NE(at, std::string::npos) << text;
  if (at == std::string::npos) return -1;
  at = text.find_first_of("0123456789", at);
  return std::strtod(text.c_str() + at, nullptr);
}

DeviationStatistics by_meshlab(const geometry::TriangleMesh& from,
                               const geometry::TriangleMesh& to) {
  const TemporaryFolder folder;
  geometry::write_mesh_file(folder / "from.ply", from);
  geometry::write_mesh_file(folder / "to.ply", to);
  std::ofstream(folder / "script.mlx") << kScript;
  const std::string command = std::string(MESHLABSERVER) + " -i " + (folder / "from.ply").string() +
                              " -i " + (folder / "to.ply").string() + " -s " +
                              (folder / "script.mlx").string() + " > " + (folder / "log").string() +
                              " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::stringstream log;
  log << std::ifstream(folder / "log").rdbuf();
  DeviationStatistics result;
  result.mean = number_after(log.str(), "mean");
  result.max = number_after(log.str(), "max");
  const double rms = number_after(log.str(), "RMS");
  result.variance = rms * rms - result.mean * result.mean;
  return result;
}

void expect_same(const DeviationStatistics& ours, const DeviationStatistics& meshlab, double size) {
  EXPECT_NEAR(ours.mean, meshlab.mean, 0.03 * ours.mean + 1e-4 * size);
  EXPECT_NEAR(std::sqrt(ours.variance), std::sqrt(meshlab.variance),
              0.03 * std::sqrt(ours.variance) + 1e-4 * size);
  EXPECT_NEAR(ours.max, meshlab.max, 0.02 * ours.max + 1e-3 * size);
}

TEST(MeshLab, MeasuresTheSameDeviations) {
  const auto l_shape = subdivided(make_l_shape(1), 2);
  const auto ball = shifted(geometry::make_sphere(1.1, 64), {0.9, 0.8, 0.4});
  const MeshDeviation ours = mesh_deviation(l_shape, ball, {.samples = 100000});
  expect_same(ours.to_second, by_meshlab(l_shape, ball), 1);
  expect_same(ours.from_second, by_meshlab(ball, l_shape), 1);
}

}  // namespace
}  // namespace prehend::surface
