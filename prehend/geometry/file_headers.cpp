#include "prehend/geometry/file_headers.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

constexpr std::size_t kMaxFields = 256;
constexpr std::size_t kMaxHeaderLine = 4096;  // bytes
constexpr std::size_t kMaxHeaderLines = 10000;
// LZF packs at most 264 bytes into 3.
constexpr std::size_t kMaxCompression = 88;
// PCL indexes points and bytes with signed 32-bit integers.
constexpr std::size_t kMaxPoints = std::numeric_limits<std::int32_t>::max();

const std::string kCopyAgain = "Copy or record the file again";

[[noreturn]] void refuse_header(const std::filesystem::path& path, const std::string& what,
                                const std::string& mend = kCopyAgain) {
  throw InputError('\'' + path.string() + "' " + what, mend);
}

// One header line without its end; false at the end of the file.
bool next_line(std::istream& stream, const std::filesystem::path& path, std::string& line) {
  line.clear();
  for (int c = stream.get(); c != std::char_traits<char>::eof(); c = stream.get()) {
    if (c == '\n') {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      return true;
    }
    line.push_back(static_cast<char>(c));
    if (line.size() > kMaxHeaderLine) refuse_header(path, "has no header that could be read");
  }
  return !line.empty();
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::size_t parse_count(const std::filesystem::path& path, const std::string& key,
                        const std::string& word) {
  const bool digits =
      !word.empty() && word.size() <= 18 &&
      std::all_of(word.begin(), word.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!digits)
    refuse_header(path, "has the header entry " + key + " = '" + word.substr(0, 40) +
                            "', not a whole number");
  return std::stoull(word);
}

using Entries = std::map<std::string, std::vector<std::string>>;

Entries read_pcd_entries(std::ifstream& stream, const std::filesystem::path& path) {
  Entries entries;
  std::string line;
  for (std::size_t lines = 0; lines < kMaxHeaderLines && next_line(stream, path, line); ++lines) {
    std::vector<std::string> words = words_of(line);
    if (words.empty() || words[0][0] == '#') continue;
    const std::string key = words[0];
    static const std::array<const char*, 10> kKeys = {"VERSION",   "FIELDS", "COLUMNS", "SIZE",
                                                      "TYPE",      "COUNT",  "WIDTH",   "HEIGHT",
                                                      "VIEWPOINT", "POINTS"};
    const bool known = std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end();
    if (!known && key != "DATA")
      refuse_header(path, "is not a PCD file", "Pass a .pcd or .ply cloud");
    words.erase(words.begin());
    entries[key == "COLUMNS" ? "FIELDS" : key] = std::move(words);
    if (key == "DATA") return entries;
  }
  refuse_header(path, entries.empty() ? "is not a PCD file" : "has a PCD header without DATA line");
}

const std::vector<std::string>& entry(const Entries& entries, const std::filesystem::path& path,
                                      const std::string& key, std::size_t count) {
  const auto found = entries.find(key);
  if (found == entries.end()) refuse_header(path, "has a PCD header without " + key);
  if (found->second.size() != count) {
    refuse_header(path, "has " + std::to_string(found->second.size()) + " values of " + key +
                            ", not " + std::to_string(count));
  }
  return found->second;
}

// Bytes of one point, from SIZE, TYPE and COUNT.
std::size_t point_bytes(const Entries& entries, const std::filesystem::path& path,
                        const std::vector<std::string>& fields, std::size_t& values) {
  const auto& sizes = entry(entries, path, "SIZE", fields.size());
  const auto& types = entry(entries, path, "TYPE", fields.size());
  const bool counted = entries.contains("COUNT");
  std::size_t bytes = 0;
  values = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::size_t size = parse_count(path, "SIZE", sizes[i]);
    const std::size_t count =
        counted ? parse_count(path, "COUNT", entry(entries, path, "COUNT", fields.size())[i]) : 1;
    const bool is_float = types[i] == "F" && (size == 4 || size == 8);
    const bool is_whole =
        (types[i] == "I" || types[i] == "U") && (size == 1 || size == 2 || size == 4 || size == 8);
    if ((!is_float && !is_whole) || count == 0 || count > 65536) {
      refuse_header(path, "has field '" + fields[i] + "' of impossible type " + types[i] +
                              ", size " + sizes[i] + " or count");
    }
    const bool coordinate = fields[i] == "x" || fields[i] == "y" || fields[i] == "z";
    if (coordinate && (!is_float || count != 1)) {
      refuse_header(path,
                    "has a coordinate '" + fields[i] + "' that is not one floating-point number",
                    "Convert it with pcl_convert_pcd_ascii_binary or CloudCompare");
    }
    bytes += size * count;
    values += count;
  }
  return bytes;
}

void require_coordinates(const std::filesystem::path& path,
                         const std::vector<std::string>& fields) {
  for (const char* name : {"x", "y", "z"}) {
    if (std::count(fields.begin(), fields.end(), name) != 1) {
      refuse_header(path, std::string("does not have exactly one field '") + name + "'",
                    "Pass a cloud with x, y and z");
    }
  }
}

std::optional<RigidTransform> parse_viewpoint(const Entries& entries,
                                              const std::filesystem::path& path) {
  if (!entries.contains("VIEWPOINT")) return std::nullopt;
  std::array<double, 7> value{};
  const auto& words = entry(entries, path, "VIEWPOINT", 7);
  for (std::size_t i = 0; i < 7; ++i) {
    char* end = nullptr;
    value[i] = std::strtod(words[i].c_str(), &end);
    if (end == words[i].c_str() || *end != '\0') {
      refuse_header(path, "has VIEWPOINT value '" + words[i].substr(0, 40) + "', not a number");
    }
  }
  const Eigen::Quaterniond q(value[3], value[4], value[5], value[6]);
  const Eigen::Vector3d p(value[0], value[1], value[2]);
  if (!p.allFinite() || !q.coeffs().allFinite() || q.norm() < 1e-6) return std::nullopt;
  return make_transform(q, p);
}

// PCL reads words as NaN and takes missing values from the next line without a word.
void check_ascii_points(std::ifstream& stream, const std::filesystem::path& path,
                        std::size_t points, std::size_t values) {
  std::string line;
  for (std::size_t i = 0; i < points; ++i) {
    if (!std::getline(stream, line)) {
      refuse_header(path, "is truncated: it has " + std::to_string(i) + " of " +
                              std::to_string(points) + " points");
    }
    std::size_t count = 0;
    for (const char* position = line.c_str(); count <= values; ++count) {
      char* end = nullptr;
      std::strtod(position, &end);
      if (end == position) {
        position += std::strspn(position, " \t\r");
        if (*position == '\0') break;
        refuse_header(
            path, "has a point with a value that is not a number, in point " + std::to_string(i));
      }
      position = end;
    }
    if (count != values) {
      refuse_header(path,
                    "has a point with too few or too many values, point " + std::to_string(i));
    }
  }
}

void check_pcd_body(std::ifstream& stream, const std::filesystem::path& path,
                    const PcdHeader& header, std::size_t bytes_per_point, std::size_t values,
                    std::size_t file_size) {
  const std::size_t remaining = file_size - static_cast<std::size_t>(stream.tellg());
  const auto fail_short = [&](std::size_t needed) {
    refuse_header(path, "is truncated: its header promises " + std::to_string(header.points) +
                            " points, which need " + std::to_string(needed) + " bytes; " +
                            std::to_string(remaining) + " are there");
  };
  const std::size_t size = header.points * bytes_per_point;
  if (header.encoding == "binary" && size > remaining) fail_short(size);
  if (header.encoding == "ascii" && header.points * values * 2 - 1 > remaining) {
    fail_short(header.points * values * 2 - 1);
  }
  if (header.encoding == "ascii") check_ascii_points(stream, path, header.points, values);
  if (header.encoding != "binary_compressed") return;
  std::array<std::uint32_t, 2> sizes{};  // compressed, uncompressed
  if (remaining < sizeof sizes) fail_short(sizeof sizes);
  stream.read(reinterpret_cast<char*>(sizes.data()), sizeof sizes);
  if (sizes[0] > remaining - sizeof sizes) fail_short(sizeof sizes + sizes[0]);
  if (sizes[1] != size || size / kMaxCompression > sizes[0]) {
    refuse_header(path, "says that its compressed data hold " + std::to_string(sizes[1]) +
                            " bytes, but " + std::to_string(header.points) + " points need " +
                            std::to_string(size));
  }
}

PlyNumber ply_number(const std::filesystem::path& path, const std::string& type) {
  static const std::map<std::string, PlyNumber> kTypes = {
      {"char", PlyNumber::kInt8},      {"int8", PlyNumber::kInt8},
      {"uchar", PlyNumber::kUint8},    {"uint8", PlyNumber::kUint8},
      {"short", PlyNumber::kInt16},    {"int16", PlyNumber::kInt16},
      {"ushort", PlyNumber::kUint16},  {"uint16", PlyNumber::kUint16},
      {"int", PlyNumber::kInt32},      {"int32", PlyNumber::kInt32},
      {"uint", PlyNumber::kUint32},    {"uint32", PlyNumber::kUint32},
      {"float", PlyNumber::kFloat32},  {"float32", PlyNumber::kFloat32},
      {"double", PlyNumber::kFloat64}, {"float64", PlyNumber::kFloat64}};
  const auto found = kTypes.find(type);
  if (found == kTypes.end())
    refuse_header(path, "has a PLY property of unknown type '" + type + "'");
  return found->second;
}

PlyProperty parse_ply_property(const std::filesystem::path& path,
                               const std::vector<std::string>& words) {
  if (words.size() == 5 && words[1] == "list") {
    const PlyNumber length = ply_number(path, words[2]);
    if (length == PlyNumber::kFloat32 || length == PlyNumber::kFloat64) {
      refuse_header(path, "has a PLY list whose length is not a whole number");
    }
    return {words[4], ply_number(path, words[3]), length};
  }
  if (words.size() != 3) refuse_header(path, "has a PLY property line that could not be read");
  return {words[2], ply_number(path, words[1]), std::nullopt};
}

std::vector<PlyElement> read_ply_elements(std::ifstream& stream, const std::filesystem::path& path,
                                          std::string& format) {
  std::vector<PlyElement> elements;
  std::string line;
  if (!next_line(stream, path, line) || line != "ply") refuse_header(path, "is not a PLY file");
  for (std::size_t lines = 0; lines < kMaxHeaderLines && next_line(stream, path, line); ++lines) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") return elements;
    if (words[0] == "format" && words.size() == 3) {
      format = words[1];
    } else if (words[0] == "element" && words.size() == 3) {
      elements.push_back({words[1], parse_count(path, "element " + words[1], words[2]), {}});
    } else if (words[0] == "property" && !elements.empty() &&
               elements.back().properties.size() < kMaxFields) {
      elements.back().properties.push_back(parse_ply_property(path, words));
    } else {
      refuse_header(path,
                    "has a PLY header line that could not be read: '" + line.substr(0, 60) + "'");
    }
  }
  refuse_header(path, "has a PLY header without end_header");
}

}  // namespace

std::size_t checked_file_size(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    refuse_header(path, "does not exist",
                  "Check the path; relative ones start at the working directory");
  }
  if (!std::filesystem::is_regular_file(path, error))
    refuse_header(path, "is not a file", "Pass a file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error)
    refuse_header(path, "could not be examined: " + error.message(), "Check its permissions");
  if (size == 0) refuse_header(path, "is empty");
  if (!std::ifstream(path, std::ios::binary).good()) {
    refuse_header(path, "could not be opened", "Check its permissions");
  }
  return static_cast<std::size_t>(size);
}

std::string lower_case_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

PcdHeader read_pcd_header(const std::filesystem::path& path) {
  const std::size_t file_size = checked_file_size(path);
  std::ifstream stream(path, std::ios::binary);
  const Entries entries = read_pcd_entries(stream, path);

  PcdHeader header;
  if (!entries.contains("FIELDS")) refuse_header(path, "has a PCD header without FIELDS");
  header.fields = entries.at("FIELDS");
  if (header.fields.size() > kMaxFields) refuse_header(path, "has too many fields");
  require_coordinates(path, header.fields);
  std::size_t values = 0;
  const std::size_t bytes = point_bytes(entries, path, header.fields, values);

  header.points = parse_count(path, "POINTS", entry(entries, path, "POINTS", 1)[0]);
  header.width = parse_count(path, "WIDTH", entry(entries, path, "WIDTH", 1)[0]);
  header.height = entries.contains("HEIGHT")
                      ? parse_count(path, "HEIGHT", entry(entries, path, "HEIGHT", 1)[0])
                      : 1;
  if (header.points == 0) refuse_header(path, "has no points", "Record the cloud again");
  // Every point takes a byte at least, so no honest count exceeds the compressed file's capacity.
  if (header.points > kMaxPoints || header.points / kMaxCompression > file_size) {
    refuse_header(path, "promises " + std::to_string(header.points) + " points in " +
                            std::to_string(file_size) + " bytes");
  }
  if (header.width == 0 || header.height == 0 || header.width > header.points ||
      header.height > header.points || header.width * header.height != header.points) {
    refuse_header(path, "has WIDTH x HEIGHT = " + std::to_string(header.width) + " x " +
                            std::to_string(header.height) +
                            ", which is not POINTS = " + std::to_string(header.points));
  }
  header.encoding = entry(entries, path, "DATA", 1)[0];
  if (header.encoding != "ascii" && header.encoding != "binary" &&
      header.encoding != "binary_compressed") {
    refuse_header(path, "has DATA of unknown kind '" + header.encoding.substr(0, 40) + "'");
  }
  header.viewpoint = parse_viewpoint(entries, path);
  check_pcd_body(stream, path, header, bytes, values, file_size);
  return header;
}

std::size_t size_of(PlyNumber type) {
  switch (type) {
    case PlyNumber::kInt8:
    case PlyNumber::kUint8:
      return 1;
    case PlyNumber::kInt16:
    case PlyNumber::kUint16:
      return 2;
    case PlyNumber::kFloat64:
      return 8;
    default:
      return 4;
  }
}

PlyHeader read_ply_header(const std::filesystem::path& path) {
  const std::size_t file_size = checked_file_size(path);
  std::ifstream stream(path, std::ios::binary);
  PlyHeader header;
  header.elements = read_ply_elements(stream, path, header.format);
  const std::string& format = header.format;
  if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian") {
    refuse_header(path, "has the unknown PLY format '" + format + "'");
  }
  header.body_offset = static_cast<std::size_t>(stream.tellg());
  const std::size_t remaining = file_size - header.body_offset;

  std::size_t needed = 0;
  for (const PlyElement& element : header.elements) {
    std::size_t bytes = 0;  // that one row needs at least
    std::vector<std::string> names;
    for (const PlyProperty& property : element.properties) {
      bytes += format == "ascii" ? 2 : size_of(property.list_length.value_or(property.type));
      names.push_back(property.name);
    }
    if (element.count > kMaxPoints || element.count * bytes > remaining + 1 ||
        (bytes == 0 && element.count > 0)) {
      needed = std::numeric_limits<std::size_t>::max();
    } else {
      needed += element.count * bytes;
    }
    if (needed > remaining + 1) {
      refuse_header(path, "is truncated: its header promises " + std::to_string(element.count) +
                              " of '" + element.name + "', more than its " +
                              std::to_string(remaining) + " bytes can hold");
    }
    if (element.name == "vertex") {
      header.vertices = element.count;
      require_coordinates(path, names);
    }
    if (element.name == "face") header.faces = element.count;
    if (element.name == "camera" && element.count > 0) header.has_camera = true;
  }
  if (header.vertices == 0) refuse_header(path, "has no points", "Record the cloud again");
  return header;
}

}  // namespace prehend::geometry
