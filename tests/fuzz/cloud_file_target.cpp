// A recorded cloud: `kind byte | file`, p of PLY, else of PCD. One that is read is interpreted, as
// `prehend plan` does with it, down to its objects.

#include <cstdint>
#include <stdexcept>

#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/recorded_cloud.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend;

void check(const geometry::CloudFile& file) {
  const geometry::PointCloud& cloud = file.cloud;
  FUZZ_CHECK(!cloud.empty());
  FUZZ_CHECK(cloud.normals.empty() || cloud.normals.size() == cloud.size());
  FUZZ_CHECK(cloud.colors.empty() || cloud.colors.size() == cloud.size());
  FUZZ_CHECK(file.labels.empty() || file.labels.size() == cloud.size());
  if (cloud.organized()) {
    FUZZ_CHECK(static_cast<std::size_t>(cloud.width) * static_cast<std::size_t>(cloud.height) ==
               cloud.size());
  }
  if (file.viewpoint) FUZZ_CHECK(file.viewpoint->matrix().allFinite());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  fuzz::FuzzInput input(data, size);
  const char* const name = input.byte() == 'p' ? "cloud.ply" : "cloud.pcd";
  const auto path = folder.write(name, input.rest());
  try {
    const geometry::CloudFile file = geometry::read_cloud_file(path);
    check(file);
    const auto recorded = perception::interpret_recorded_cloud(file);
    FUZZ_CHECK(recorded.X_FC.matrix().allFinite());
    perception::segment_recorded_cloud(recorded);
  } catch (const geometry::InputError&) {
  }
  return 0;
}
