#include "prehend/robot/formats/archive.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <utility>

#include <minizip/unzip.h>
#include <minizip/zip.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {
namespace {

constexpr std::size_t kMostUnpacked = 64 << 20;

struct CloseArchive {
  void operator()(void* archive) const { unzClose(archive); }
};

/// What minizip takes for a file: bytes in memory, and where the next are written.
struct Bytes {
  std::string text;
  std::size_t at = 0;
};

Bytes& bytes_of(void* stream) { return *static_cast<Bytes*>(stream); }

long seek_in_bytes(void*, void* stream, ZPOS64_T offset, int origin) {
  Bytes& bytes = bytes_of(stream);
  const std::size_t from = origin == ZLIB_FILEFUNC_SEEK_SET   ? 0
                           : origin == ZLIB_FILEFUNC_SEEK_CUR ? bytes.at
                                                              : bytes.text.size();
  bytes.at = from + offset;
  return bytes.at <= bytes.text.size() ? 0 : -1;
}

uLong read_bytes(void*, void* stream, void* into, uLong size) {
  Bytes& bytes = bytes_of(stream);
  const std::size_t count = bytes.text.copy(static_cast<char*>(into), size, bytes.at);
  bytes.at += count;
  return static_cast<uLong>(count);
}

/// Over what is there, and behind it: minizip writes a file's length into its head afterwards.
uLong write_bytes(void*, void* stream, const void* from, uLong size) {
  Bytes& bytes = bytes_of(stream);
  const std::size_t over = std::min<std::size_t>(size, bytes.text.size() - bytes.at);
  bytes.text.replace(bytes.at, over, static_cast<const char*>(from), size);
  bytes.at += size;
  return size;
}

zlib_filefunc64_def file_in(Bytes& bytes) {
  zlib_filefunc64_def file{};
  file.zopen64_file = [](void* opaque, const void*, int) { return opaque; };
  file.zread_file = read_bytes;
  file.zwrite_file = write_bytes;
  file.ztell64_file = [](void*, void* stream) -> ZPOS64_T { return bytes_of(stream).at; };
  file.zseek64_file = seek_in_bytes;
  file.zclose_file = [](void*, void*) { return 0; };
  file.zerror_file = [](void*, void*) { return 0; };
  file.opaque = &bytes;
  return file;
}

bool pack_file(zipFile zip, const std::string& name, const std::string& text) {
  zip_fileinfo info{};
  info.dosDate = (1U << 21) | (1U << 16);  // the first month's first day of 1980
  return text.size() <= std::numeric_limits<unsigned>::max() &&
         zipOpenNewFileInZip(zip, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                             Z_DEFAULT_COMPRESSION) == ZIP_OK &&
         zipWriteInFileInZip(zip, text.data(), static_cast<unsigned>(text.size())) == ZIP_OK &&
         zipCloseFileInZip(zip) == ZIP_OK;
}

}  // namespace

bool is_archive(std::string_view bytes) { return bytes.starts_with("PK\x03\x04"); }

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

std::string archive_of(const std::vector<std::pair<std::string, std::string>>& files) {
  Bytes bytes;
  zlib_filefunc64_def in_memory = file_in(bytes);
  zipFile zip = zipOpen2_64("", APPEND_STATUS_CREATE, nullptr, &in_memory);
  bool is_whole = zip != nullptr;
  for (const auto& [name, text] : files) is_whole = is_whole && pack_file(zip, name, text);
  if (zip) is_whole = zipClose(zip, nullptr) == ZIP_OK && is_whole;
  if (!is_whole) {
    throw geometry::InputError("the archive cannot be packed", "Write the document itself, .dae");
  }
  return std::move(bytes.text);
}

}  // namespace prehend::robot::formats
