#include "prehend/viewing/access.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace prehend::viewing {
namespace {

// Takes as long wherever they differ.
bool is_same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = static_cast<unsigned char>(difference | (a[i] ^ b[i]));
  }
  return difference == 0;
}

std::string query_value(std::string_view target, std::string_view name) {
  const std::size_t mark = target.find('?');
  if (mark == std::string_view::npos) return "";
  std::string_view query = target.substr(mark + 1);
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view one = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    const std::size_t equals = one.find('=');
    if (equals == std::string_view::npos || one.substr(0, equals) != name) continue;
    return percent_decoded(one.substr(equals + 1)).value_or("");
  }
  return "";
}

std::string_view without_port(std::string_view host) {
  if (!host.empty() && host.front() == '[') return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

}  // namespace

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result += text[i];
      continue;
    }
    if (i + 2 >= text.size()) return std::nullopt;
    const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
    if (high < 0 || low < 0 || high + low == 0) return std::nullopt;
    result += static_cast<char>(16 * high + low);
    i += 2;
  }
  return result;
}

bool is_loopback_host(std::string_view host) {
  const std::string name = lower(without_port(host));
  if (name == "localhost" || name == "[::1]" || name == "::1" || host == "::1") return true;
  return name.rfind("127.", 0) == 0 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c == '.' || std::isdigit(c); });
}

std::string objection(const AccessRules& rules, const AccessRequest& request) {
  if (rules.loopback && !is_loopback_host(request.host)) {
    return fmt::format(
        "this server is for this machine alone, and '{}' is no name of it: open it as "
        "127.0.0.1 or localhost",
        request.host);
  }
  if (request.origin) {
    const std::string origin = lower(*request.origin);
    const std::size_t scheme = origin.find("://");
    const bool same =
        scheme != std::string::npos && origin.substr(scheme + 3) == lower(request.host);
    const auto is_it = [&](const std::string& allowed) {
      return allowed == "*" || lower(allowed) == origin;
    };
    if (!same && std::none_of(rules.allowed_origins.begin(), rules.allowed_origins.end(), is_it)) {
      return fmt::format(
          "pages of '{}' may not look at this robot: start the viewer with "
          "allowed_origins:=[{}] if they are to",
          *request.origin, *request.origin);
    }
  }
  if (!rules.token.empty() && !is_same_secret(query_value(request.target, "token"), rules.token)) {
    return "the address needs the token that the viewer wrote when it started: /?token=...";
  }
  return "";
}

}  // namespace prehend::viewing
