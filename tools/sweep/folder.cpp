#include "tools/sweep/folder.h"

#include <algorithm>
#include <regex>

#include <fmt/format.h>

#include "prehend/text/input_error.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using text::InputError;

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError("'" + folder.string() + "' cannot be made: " + error.message(),
                     "Name another --out");
  }
}

}  // namespace

Part Part::parse(const std::string& text) {
  static const std::regex kPart(R"((\d{1,6})/(\d{1,6}))");
  std::smatch match;
  Part part;
  if (std::regex_match(text, match, kPart)) part = {std::stoi(match[1]), std::stoi(match[2])};
  if (part.number < 1 || part.number > part.of) {
    throw InputError("'" + text + "' is no part", "Write K/N, from 1/8 to 8/8");
  }
  return part;
}

SweepFolder::SweepFolder(const fs::path& folder) : folder_(fs::absolute(folder)) {
  make_folder(folder_);
}

fs::path SweepFolder::part(const Part& part) const {
  return folder_ / "parts" / fmt::format("{}-of-{}.db", part.number, part.of);
}

fs::path SweepFolder::case_folder(const std::string& name) const {
  return folder_ / "cases" / name;
}

std::vector<fs::path> SweepFolder::parts(const fs::path& except) const {
  std::vector<fs::path> found;
  std::error_code error;  // there are none when there is no folder
  for (const auto& entry : fs::directory_iterator(folder_ / "parts", error)) {
    if (entry.path().extension() == ".db" && entry.path() != except) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::unique_ptr<sweep::FolderLock> SweepFolder::lock_whole() const {
  return std::make_unique<sweep::FolderLock>(folder_ / "lock", false, "'" + folder_.string() + "'");
}

std::pair<std::unique_ptr<sweep::FolderLock>, std::unique_ptr<sweep::FolderLock>>
SweepFolder::lock_part(const Part& part) const {
  make_folder(folder_ / "parts");
  const std::string what = fmt::format("'{}'", folder_.string());
  auto shared = std::make_unique<sweep::FolderLock>(folder_ / "lock", true, what);
  fs::path own = this->part(part);
  own.replace_extension(".lock");
  return {std::move(shared),
          std::make_unique<sweep::FolderLock>(
              own, false, fmt::format("Part {}/{} of {}", part.number, part.of, what))};
}

int SweepFolder::merge_into(sweep::ResultStore& store) const {
  const std::vector<fs::path> files = parts();
  for (const fs::path& file : files) {
    store.take_from(sweep::ResultStore(file, text::DatabaseUse::kRead));
    std::error_code ignored;  // what stays is merged once more, with the same end
    fs::remove(file, ignored);
    fs::remove(file.string() + "-journal", ignored);
    fs::remove(fs::path(file).replace_extension(".lock"), ignored);
  }
  return static_cast<int>(files.size());
}

FolderResults::FolderResults(const SweepFolder& folder, const fs::path& except) {
  std::vector<fs::path> files = folder.parts(except);
  if (fs::exists(folder.results())) files.insert(files.begin(), folder.results());
  for (const fs::path& file : files) {
    stores_.push_back(std::make_unique<sweep::ResultStore>(file, text::DatabaseUse::kRead));
  }
}

bool FolderResults::has(const std::string& name) const {
  return std::any_of(stores_.begin(), stores_.end(),
                     [&](const auto& store) { return store->has(name); });
}

std::optional<sweep::CaseResult> FolderResults::find(const std::string& name) const {
  for (const auto& store : stores_) {
    if (auto result = store->find(name)) return result;
  }
  return std::nullopt;
}

std::optional<double> FolderResults::seconds(const std::string& name) const {
  for (const auto& store : stores_) {
    if (const auto seconds = store->seconds(name)) return seconds;
  }
  return std::nullopt;
}

void FolderResults::check(const sweep::Description& description) const {
  for (const auto& store : stores_) store->check(description);
}

}  // namespace prehend::tools
