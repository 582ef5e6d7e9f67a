#pragma once

#include <string>
#include <vector>

namespace prehend::nodes {

/// Rows of "what", "value": prehend's version, with the revision of a checkout, and the command
/// that launched the run where one did (PREHEND_COMMAND, as `prehend launch` sets it).
std::vector<std::vector<std::string>> made_by();

}  // namespace prehend::nodes
