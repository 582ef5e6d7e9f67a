#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace prehend::viewing {

/// What is answered to GET.
struct PageFile {
  int status = 200;  ///< of HTTP
  std::string type;  ///< media type
  std::string content;
};

/// The file of `folder` that a request's target means; "/" is index.html. Files whose name begins
/// with '.', what is no plain file, and whatever lies outside of the folder, by ".." or by a link,
/// are not there (404); a target that means nothing is refused (400); both with words.
PageFile page_file(const std::filesystem::path& folder, std::string_view target);

/// Content-Security-Policy of all pages: nothing comes from elsewhere, no script stands in a page,
/// and no other page frames it. Pages may connect to any viewer.
inline constexpr const char* kContentSecurityPolicy =
    "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' blob: data:; style-src "
    "'self'; "
    "script-src 'self'; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; "
    "frame-ancestors 'none'";

}  // namespace prehend::viewing
