#pragma once

#include <string>

namespace prehend::text {

/// A file or folder of prehend's tree, named from its top, e.g. "config/robots/pg70_dsa.yaml": that
/// name where the working directory has it, else the path in the folder PREHEND_ROOT names, else
/// in the nearest folder above the running program that has it; the name itself when nobody has it.
/// So programs find their defaults wherever they are started.
std::string tree_file(const std::string& name);

}  // namespace prehend::text
