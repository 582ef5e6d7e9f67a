#pragma once

#include <filesystem>
#include <string>

#include "prehend/graph/introspection.h"

namespace prehend::tools {

/// Which robot a command is about.
struct FoundPlatform {
  std::filesystem::path file;
  std::string said_by;  // "--platform", "node simulation", or that nobody did
};

/// `given` (a name or file; of config/robots), else what the running graph's nodes say by their
/// parameters `platform` or `robot`, else stage_pg70, as launch files have it.
/// @throws geometry::InputError for a name that there is not; std::runtime_error naming both where
/// nodes say different ones, and when the registry does not answer.
FoundPlatform find_platform(graph::Introspection& graph, const std::string& given);

}  // namespace prehend::tools
