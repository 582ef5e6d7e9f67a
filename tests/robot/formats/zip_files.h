#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <minizip/zip.h>

namespace prehend::robot::formats {

/// A zip of files by name.
inline void pack(const std::filesystem::path& archive,
                 const std::vector<std::pair<std::string, std::string>>& files) {
  zipFile zip = zipOpen(archive.c_str(), APPEND_STATUS_CREATE);
  ASSERT_TRUE(zip);
  for (const auto& [name, text] : files) {
    ASSERT_EQ(zipOpenNewFileInZip(zip, name.c_str(), nullptr, nullptr, 0, nullptr, 0, nullptr,
                                  Z_DEFLATED, 9),
              ZIP_OK);
    zipWriteInFileInZip(zip, text.data(), static_cast<unsigned>(text.size()));
    zipCloseFileInZip(zip);
  }
  zipClose(zip, nullptr);
}

}  // namespace prehend::robot::formats
