#pragma once

#include <string>
#include <vector>

namespace prehend::tools {

/// The folder of the running executable, where the nodes' programs are, too.
std::string program_folder();

/// Where the programs of nodes are looked for, separated by ':': program_folder, then the folders
/// in PREHEND_NODE_PATH.
std::string node_path();

/// Becomes the program `name` of that folder; returns only by throwing std::runtime_error.
[[noreturn]] void become_program(const std::string& name,
                                 const std::vector<std::string>& arguments);

}  // namespace prehend::tools
