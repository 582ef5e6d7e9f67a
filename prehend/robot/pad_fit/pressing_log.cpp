#include "prehend/robot/pad_fit/pressing_log.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/csv_table.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot {
namespace {

using geometry::InputError;
using Table = text::CsvTable;

constexpr double kNanosecond = 1e-9;  // s

// See docs/touch.md for the columns.
Table read_table(const std::filesystem::path& file) {
  return text::read_csv_table(file, 2, "See docs/touch.md for the columns of a pressing log");
}

std::vector<double> times_of(const Table& table, const std::string& name) {
  int column = table.index(name);
  double scale = 1;
  if (column < 0 && name == "time") {
    column = table.index("log_time");
    scale = kNanosecond;
  }
  if (column < 0) {
    throw InputError(fmt::format("{} has no column '{}'{}", table.file.string(), name,
                                 text::nearest_match_hint(name, table.names)),
                     "Add it, in seconds, or name it: --column time=NAME");
  }
  std::vector<double> time = table.numbers(column);
  const double start = time.front();  // nanoseconds since 1970 would lose digits
  if (scale != 1) {
    for (double& t : time) t = scale * (t - start) + scale * start;
  }
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] > time[i - 1]) continue;
    throw InputError(
        fmt::format("{}:{}: the time does not increase", table.file.string(), table.lines[i]),
        "Sort the rows by time, one for each");
  }
  return time;
}

double interpolated(const std::vector<double>& at, const std::vector<double>& values, double t) {
  const auto after = std::upper_bound(at.begin() + 1, at.end() - 1, t);
  const auto i = static_cast<std::size_t>(after - at.begin());
  const double part = (t - at[i - 1]) / (at[i] - at[i - 1]);
  return values[i - 1] + part * (values[i] - values[i - 1]);
}

class Reader {
 public:
  Reader(const std::vector<std::filesystem::path>& files,
         const std::map<std::string, std::string>& columns)
      : columns_(columns) {
    for (const auto& [name, other] : columns) {
      if (name == "time" || name == "depth" || name == "opening" || name == "force") continue;
      throw InputError("'" + name + "' is no column of a pressing log",
                       "Name time, depth, opening or force");
    }
    for (const std::filesystem::path& file : files) {
      tables_.push_back(read_table(file));
      times_.push_back(times_of(tables_.back(), in_files("time")));
    }
  }

  PressingLog read() {
    PressingLog log;
    log.name = tables_.front().file.string();
    double begin = times_[0].front(), end = times_[0].back();
    for (const std::vector<double>& time : times_) {
      begin = std::max(begin, time.front());
      end = std::min(end, time.back());
    }
    std::size_t first = 0, last = times_[0].size();
    while (first < last && times_[0][first] < begin) ++first;
    while (last > first && times_[0][last - 1] > end) --last;
    if (last - first < 2) {
      throw InputError(log.name + " shares no time with the other files",
                       "Give files of one recording");
    }
    log.time.assign(times_[0].begin() + static_cast<std::ptrdiff_t>(first),
                    times_[0].begin() + static_cast<std::ptrdiff_t>(last));
    std::optional<std::vector<double>> depth = column(in_files("depth"), first, last);
    const std::optional<std::vector<double>> opening = column(in_files("opening"), first, last);
    if (depth && opening) {
      throw InputError(log.name + " has both a depth and an opening", "Keep one of the columns");
    }
    if (opening) {
      depth = opening;
      for (double& d : *depth) d *= -0.5;
    }
    if (!depth)
      missing("depth", "how deep the face is in the pad [m], or `opening`, of the jaws [m]");
    log.depth = std::move(*depth);
    auto force = column(in_files("force"), first, last);
    if (!force) missing("force", "what a scale or the gripper shows [N]");
    log.force = std::move(*force);
    read_counts(first, last, log);
    return log;
  }

 private:
  std::string in_files(const std::string& name) const {
    const auto found = columns_.find(name);
    return found == columns_.end() ? name : found->second;
  }

  [[noreturn]] void missing(const std::string& name, const std::string& meaning) const {
    std::vector<std::string> all;
    for (const Table& table : tables_)
      all.insert(all.end(), table.names.begin(), table.names.end());
    throw InputError(fmt::format("{} has no column '{}'{}", tables_.front().file.string(),
                                 in_files(name), text::nearest_match_hint(in_files(name), all)),
                     fmt::format("Add it: {}; or name it: --column {}=NAME", meaning, name));
  }

  // At the first file's times; none where no file has it.
  std::optional<std::vector<double>> column(const std::string& name, std::size_t first,
                                            std::size_t last) const {
    for (std::size_t f = 0; f < tables_.size(); ++f) {
      const int index = tables_[f].index(name);
      if (index < 0) continue;
      const std::vector<double> all = tables_[f].numbers(index);
      std::vector<double> values;
      for (std::size_t i = first; i < last; ++i) {
        values.push_back(f == 0 ? all[i] : interpolated(times_[f], all, times_[0][i]));
      }
      return values;
    }
    return std::nullopt;
  }

  void read_counts(std::size_t first, std::size_t last, PressingLog& log) const {
    const Table& table = tables_.front();
    for (const char* stem : {"count", "intensity"}) {
      std::vector<std::vector<double>> texels;
      while (true) {
        const int index = table.index(fmt::format("{}[{}]", stem, texels.size()));
        if (index < 0) break;
        texels.push_back(table.numbers(index));
      }
      if (texels.empty()) continue;
      log.texels = static_cast<int>(texels.size());
      for (std::size_t i = first; i < last; ++i) {
        for (const std::vector<double>& texel : texels) {
          if (texel[i] >= 0 && texel[i] <= 65535 && texel[i] == std::floor(texel[i])) {
            log.counts.push_back(static_cast<std::uint16_t>(texel[i]));
            continue;
          }
          throw InputError(fmt::format("{}:{}: {} is no count of a texel", table.file.string(),
                                       table.lines[i], texel[i]),
                           "Write whole numbers from 0 on, as the controller says them");
        }
      }
      return;
    }
    throw InputError(table.file.string() + " has no columns 'count[0]', 'count[1]', ...",
                     "Add one for each texel, row by row, row 0 at the fingertip; of several files "
                     "the first has them");
  }

  std::map<std::string, std::string> columns_;
  std::vector<Table> tables_;
  std::vector<std::vector<double>> times_;
};

}  // namespace

PressingLog read_pressing_log(const std::vector<std::filesystem::path>& files,
                              const std::map<std::string, std::string>& columns) {
  if (files.empty()) throw std::invalid_argument("read_pressing_log: no file");
  return Reader(files, columns).read();
}

}  // namespace prehend::robot
