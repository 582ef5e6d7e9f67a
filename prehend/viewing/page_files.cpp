#include "prehend/viewing/page_files.h"

#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

#include "prehend/viewing/access.h"

namespace prehend::viewing {
namespace {

namespace fs = std::filesystem;

PageFile words(int status, std::string text) {
  return {status, "text/plain; charset=utf-8", std::move(text) + "\n"};
}

std::string media_type(const fs::path& file) {
  static const std::pair<const char*, const char*> kTypes[] = {
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".map", "application/json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".ico", "image/x-icon"},
      {".webmanifest", "application/manifest+json"},
      {".wasm", "application/wasm"},
      {".woff2", "font/woff2"},
      {".txt", "text/plain; charset=utf-8"}};
  for (const auto& [extension, type] : kTypes) {
    if (file.extension() == extension) return type;
  }
  return "application/octet-stream";
}

// The names of a path's folders and file; nothing when it leaves its root.
std::optional<fs::path> relative_path(const std::string& path) {
  fs::path result;
  std::size_t begin = 0;
  while (begin <= path.size()) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string name = path.substr(begin, end - begin);
    begin = end + 1;
    if (name.empty()) continue;
    // Also of files that are nobody's business: .git, .env.
    if (name.front() == '.' || name.find('\\') != std::string::npos) return std::nullopt;
    result /= name;
  }
  return result;
}

bool is_within(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path real = fs::canonical(file, error);
  if (error) return false;
  const fs::path root = fs::canonical(folder, error);
  if (error) return false;
  const fs::path inside = real.lexically_relative(root);
  return !inside.empty() && *inside.begin() != "..";
}

}  // namespace

PageFile page_file(const fs::path& folder, std::string_view target) {
  const auto path = percent_decoded(target.substr(0, target.find_first_of("?#")));
  if (!path || path->empty() || path->front() != '/') {
    return words(400, "This address means nothing.");
  }
  std::optional<fs::path> inside = relative_path(*path);
  if (!inside) return words(404, "There is no such file.");
  if (inside->empty()) inside = "index.html";
  const fs::path file = folder / *inside;
  std::error_code error;
  if (!fs::is_regular_file(file, error) || !is_within(file, folder)) {
    if (*inside == "index.html") {
      return words(404, "The viewer's page is not there (" + folder.string() +
                            "). Foxglove and Lichtblick can be connected to this address all the "
                            "same, with ws:// before it.");
    }
    return words(404, "There is no such file.");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return words(404, "There is no such file.");
  return {200, media_type(file), std::string(std::istreambuf_iterator<char>(stream), {})};
}

}  // namespace prehend::viewing
