#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace prehend::robot {

/// Names of the preshapes of a platform's hand, as its file has them, for completion: nothing is
/// checked. Empty where a file cannot be read.
std::vector<std::string> preshape_names(const std::filesystem::path& platform);

}  // namespace prehend::robot
