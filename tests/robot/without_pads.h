#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

namespace prehend {

/// Copies config/robots to `folder` and takes the pads out of its bh8.yaml: the file of a platform
/// whose hand feels nothing.
inline std::filesystem::path platform_without_pads(const std::filesystem::path& folder) {
  using Options = std::filesystem::copy_options;
  std::filesystem::copy("config/robots", folder, Options::recursive | Options::overwrite_existing);
  std::ifstream in("config/robots/bh8.yaml");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = text.find("\npads:"), end = text.find("\n# Frame G");
  EXPECT_TRUE(begin != std::string::npos && end != std::string::npos && begin < end);
  text.erase(begin, end - begin);
  std::ofstream(folder / "bh8.yaml") << text;
  return folder / "pa10_barrett.yaml";
}

}  // namespace prehend
