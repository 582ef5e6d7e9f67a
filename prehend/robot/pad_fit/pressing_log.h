#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace prehend::robot {

/// How a pad was pressed by a flat face that covers it: what moved, what a reference showed, and
/// the pad's frames.
struct PressingLog {
  std::string name;          // in errors
  std::vector<double> time;  // s, increasing
  std::vector<double>
      depth;  // m, of the face into the pad, from anywhere; of an opening: - half of it
  std::vector<double> force;  // N, of the reference, on the whole pad
  int texels = 0;
  std::vector<std::uint16_t> counts;  // size() * texels, frame by frame, row by row

  std::size_t size() const { return time.size(); }
  std::uint16_t count(std::size_t sample, int texel) const {
    return counts[sample * static_cast<std::size_t>(texels) + static_cast<std::size_t>(texel)];
  }
};

/// Reads CSV files (RFC 4180) with a line of names first. Columns: `time` [s], or `log_time` [ns]
/// as `prehend bag export` writes it; `depth` [m], or `opening` [m] of jaws whose two pads press a
/// thing that stands in the middle; `force` [N]; and a column for each texel, `count[0]` or
/// `intensity[0]` on. Other columns are not read. Of several files the first one's times and frames
/// count; what is missing in it is interpolated between the rows of the others, over the time that
/// all share.
/// @param columns names in the files for these: {"force", "wrench.force.z"}
/// @throws geometry::InputError "file:line: ..." for a column that is missing, a value that is no
/// finite number, times that do not increase, counts beyond 65535, files that share no time.
PressingLog read_pressing_log(const std::vector<std::filesystem::path>& files,
                              const std::map<std::string, std::string>& columns = {});

}  // namespace prehend::robot
