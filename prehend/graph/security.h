#pragma once

#include <optional>
#include <string>

namespace prehend::graph {

/// The CURVE key pair (Curve25519, ZeroMQ RFC 26) that all members of one graph share, in Z85, 40
/// characters each. Whoever has the secret half is a member.
struct GraphKeys {
  std::string public_key;
  std::string secret_key;
};

/// Makes a pair and writes it to `file`, which from its first byte on only its user can read.
/// Throws std::runtime_error when the file exists or cannot be written.
GraphKeys create_graph_keys(const std::string& file);

/// Reads what create_graph_keys wrote. Throws std::runtime_error, naming file, line and mend, when
/// the file cannot be read, others may read it, or it holds no whole key pair.
GraphKeys load_graph_keys(const std::string& file);

/// The keys in `file`, or when that is empty in the file that PREHEND_KEYS names; none when that is
/// not set either. Throws as load_graph_keys.
std::optional<GraphKeys> find_graph_keys(const std::string& file);

/// Whether what is sent to a ZeroMQ endpoint stays on this host: ipc, inproc, and tcp with an
/// address in 127.0.0.0/8, [::1] or localhost.
bool is_local_endpoint(const std::string& endpoint);

/// Throws std::runtime_error with the mend unless the endpoint is tcp, ipc or inproc, and local or
/// protected by keys.
void check_endpoint_is_safe(const std::string& endpoint, bool has_keys);

}  // namespace prehend::graph
