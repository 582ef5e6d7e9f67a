#pragma once

#include <cstdint>
#include <string>

namespace prehend::graph {

/// Folder for the ipc sockets of one graph: BASE/prehend-PID-XXXXXX, BASE = XDG_RUNTIME_DIR if it
/// is a folder one can write to, else /tmp. Only its user can enter. A file in it stands for the
/// registry, so that it stays while that lives. Throws std::system_error.
std::string make_runtime_folder();
/// BASE/prehend-PID-XXXXXX/NODE-NODEPID-HEX of a node. Throws std::runtime_error when the path is
/// too long for a socket.
std::string socket_path(const std::string& folder, const std::string& instance);
/// Removes what dead processes left there, and the folder if it is empty then.
void clean_runtime_folder(const std::string& folder);
/// The same at the end of the folder's registry, and for the folders of dead ones.
void leave_runtime_folder(const std::string& folder);
/// The same for all folders below BASE that dead registries left.
void clean_stale_runtime_folders();

/// Within which pids can be compared: boot id and pid name space.
std::string process_space();
/// False when no such process exists or it is a zombie.
bool is_process_alive(std::int64_t pid);

}  // namespace prehend::graph
