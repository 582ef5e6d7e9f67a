// An archive of COLLADA (.zae): `kind byte | ...`. Of even kind what follows is the archive's own
// bytes; of odd kind `manifest run | document`, which are packed into one here, so that changes
// reach what is in it.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <minizip/zip.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/robot_format.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend;

void add_file(zipFile zip, const char* name, std::string_view content) {
  FUZZ_CHECK(zipOpenNewFileInZip(zip, name, nullptr, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                                 1) == ZIP_OK);
  FUZZ_CHECK(zipWriteInFileInZip(zip, content.data(), static_cast<unsigned>(content.size())) ==
             ZIP_OK);
  FUZZ_CHECK(zipCloseFileInZip(zip) == ZIP_OK);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  fuzz::FuzzInput input(data, size);
  const bool is_packed_here = input.byte() % 2 != 0;
  const std::filesystem::path file = folder.path() / "robot.zae";
  if (is_packed_here) {
    const zipFile zip = zipOpen(file.c_str(), APPEND_STATUS_CREATE);
    FUZZ_CHECK(zip != nullptr);
    add_file(zip, "manifest.xml", input.run());
    add_file(zip, "robot.dae", input.rest());
    FUZZ_CHECK(zipClose(zip, nullptr) == ZIP_OK);
  } else {
    folder.write("robot.zae", input.rest());
  }
  try {
    robot::formats::LossReport loss;
    FUZZ_CHECK(!robot::formats::read_robot(file, loss).links.empty());
  } catch (const geometry::InputError&) {
  }
  return 0;
}
