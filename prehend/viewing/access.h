#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace prehend::viewing {

/// Who may open a WebSocket.
struct AccessRules {
  bool loopback = true;  ///< the server listens on this machine alone
  std::string token;     ///< that ?token= has to be; empty: none
  /// Of pages that come from elsewhere, "https://app.foxglove.dev"; "*": all.
  std::vector<std::string> allowed_origins;
};

/// What of an upgrade request counts.
struct AccessRequest {
  std::string host;                   ///< header Host
  std::optional<std::string> origin;  ///< header Origin, which browsers always send
  std::string target;                 ///< "/?token=..."
};

/// Why a request is refused, with the mend; empty: it is not. Pages of other sites are, also those
/// that come by a name of their own for this machine (DNS rebinding); what sends no Origin is no
/// browser.
std::string objection(const AccessRules& rules, const AccessRequest& request);

/// Whether a name or address, with or without a port, is this machine's own.
bool is_loopback_host(std::string_view host);

/// %41 as A; nothing for what is damaged or says a zero byte.
std::optional<std::string> percent_decoded(std::string_view text);

}  // namespace prehend::viewing
