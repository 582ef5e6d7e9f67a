#include "prehend/robot/formats/archive.h"

#include <array>
#include <memory>

#include <minizip/unzip.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {
namespace {

constexpr std::size_t kMostUnpacked = 64 << 20;

struct CloseArchive {
  void operator()(void* archive) const { unzClose(archive); }
};

}  // namespace

bool is_archive(const std::string& bytes) { return bytes.starts_with("PK\x03\x04"); }

std::string file_of_archive(const std::filesystem::path& archive, const std::string& name) {
  const auto fail = [&](const char* what) {
    throw geometry::InputError(archive.string() + ": '" + name + "' in it " + what,
                               "Pack it anew: a .zae has manifest.xml, and what that names");
  };
  const std::unique_ptr<void, CloseArchive> zip(unzOpen(archive.string().c_str()));
  if (!zip) fail("cannot be reached: it is no whole zip");
  if (unzLocateFile(zip.get(), name.c_str(), 1) != UNZ_OK) fail("is not there");
  if (unzOpenCurrentFile(zip.get()) != UNZ_OK) fail("cannot be opened");
  std::string text;
  std::array<char, 1 << 16> buffer{};
  int count = 0;
  do {
    count = unzReadCurrentFile(zip.get(), buffer.data(), buffer.size());
    if (count < 0) fail("is damaged");
    text.append(buffer.data(), static_cast<std::size_t>(count));
    if (text.size() > kMostUnpacked) fail("is larger than 64 MiB");
  } while (count > 0);
  if (unzCloseCurrentFile(zip.get()) != UNZ_OK) fail("is damaged");
  return text;
}

}  // namespace prehend::robot::formats
