#pragma once

#include <sys/types.h>

#include <array>
#include <string>
#include <vector>

namespace prehend::testing {

/// Two hosts with a cable between them: network namespaces joined by a veth pair. The kernel
/// removes all of it when the processes in the namespaces have ended, however that happens; the one
/// that holds each namespace dies with this process. Needs root and iproute2.
class TwoHosts {
 public:
  /// Throws std::runtime_error with the reason when this machine does not permit it.
  TwoHosts();
  ~TwoHosts();
  TwoHosts(const TwoHosts&) = delete;
  TwoHosts& operator=(const TwoHosts&) = delete;

  static std::string address(int host) { return host == 0 ? "10.213.77.1" : "10.213.77.2"; }
  /// The command that runs `program` on a host, for Launched.
  std::vector<std::string> on(int host, const std::string& program) const;
  void cut_cable();
  void mend_cable();

 private:
  void hold_namespace(int host);
  /// Runs ip on a host; throws with what it says when it fails.
  void ip(int host, const std::string& arguments) const;

  std::array<pid_t, 2> holders_{-1, -1};
};

}  // namespace prehend::testing
