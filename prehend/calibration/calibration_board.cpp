#include "prehend/calibration/calibration_board.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <opencv2/aruco/charuco.hpp>

#include "prehend/calibration/marker_dictionary.h"
#include "prehend/geometry/errors.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/yaml_map.h"

namespace prehend::calibration {
namespace {

using Kind = CalibrationBoard::Kind;

constexpr int kMostColumns = 100;
constexpr double kLongest = 2.0;  // m, of a square or a tag: beyond it is millimetres
constexpr double kMostPixels = 1e8;

struct NamedDictionary {
  const char* name;
  int id;
};

constexpr std::array<NamedDictionary, 17> kCharucoDictionaries{
    {{"4x4_50", cv::aruco::DICT_4X4_50},
     {"4x4_100", cv::aruco::DICT_4X4_100},
     {"4x4_250", cv::aruco::DICT_4X4_250},
     {"4x4_1000", cv::aruco::DICT_4X4_1000},
     {"5x5_50", cv::aruco::DICT_5X5_50},
     {"5x5_100", cv::aruco::DICT_5X5_100},
     {"5x5_250", cv::aruco::DICT_5X5_250},
     {"5x5_1000", cv::aruco::DICT_5X5_1000},
     {"6x6_50", cv::aruco::DICT_6X6_50},
     {"6x6_100", cv::aruco::DICT_6X6_100},
     {"6x6_250", cv::aruco::DICT_6X6_250},
     {"6x6_1000", cv::aruco::DICT_6X6_1000},
     {"7x7_50", cv::aruco::DICT_7X7_50},
     {"7x7_100", cv::aruco::DICT_7X7_100},
     {"7x7_250", cv::aruco::DICT_7X7_250},
     {"7x7_1000", cv::aruco::DICT_7X7_1000},
     {"original", cv::aruco::DICT_ARUCO_ORIGINAL}}};
constexpr std::array<NamedDictionary, 4> kAprilTagDictionaries{
    {{"16h5", cv::aruco::DICT_APRILTAG_16h5},
     {"25h9", cv::aruco::DICT_APRILTAG_25h9},
     {"36h10", cv::aruco::DICT_APRILTAG_36h10},
     {"36h11", cv::aruco::DICT_APRILTAG_36h11}}};

template <class Visit>
void for_each_dictionary(Kind kind, Visit visit) {
  if (kind == Kind::kCharuco) {
    for (const NamedDictionary& one : kCharucoDictionaries) visit(one);
  } else if (kind == Kind::kAprilTagGrid) {
    for (const NamedDictionary& one : kAprilTagDictionaries) visit(one);
  }
}

int markers_of(const CalibrationBoard& board) {
  if (board.kind == Kind::kChessboard) return 0;
  const int fields = board.columns * board.rows;
  return board.kind == Kind::kCharuco ? fields / 2 : fields;
}

void fill(geometry::MaskImage& image, int u, int v, int width, int height, std::uint8_t value) {
  for (int y = std::max(0, v); y < std::min(image.height, v + height); ++y) {
    for (int x = std::max(0, u); x < std::min(image.width, u + width); ++x) image.at(x, y) = value;
  }
}

void put(geometry::MaskImage& image, int u, int v, const cv::Mat& stamp) {
  for (int y = 0; y < stamp.rows; ++y) {
    for (int x = 0; x < stamp.cols; ++x) image.at(u + x, v + y) = stamp.at<std::uint8_t>(y, x);
  }
}

}  // namespace

int CalibrationBoard::corners() const {
  return kind == Kind::kAprilTagGrid ? 4 * columns * rows : (columns - 1) * (rows - 1);
}

Eigen::Vector3d CalibrationBoard::corner_T(int id) const {
  if (kind != Kind::kAprilTagGrid) {
    return {square * (id % (columns - 1) + 1), square * (id / (columns - 1) + 1), 0};
  }
  const int tag = id / 4, corner = id % 4;  // clockwise from the upper left
  const double step = marker + gap;
  // Black squares of the gap's size stand before the first tag, too.
  return {gap + step * (tag % columns) + (corner == 1 || corner == 2 ? marker : 0),
          gap + step * (tag / columns) + (corner >= 2 ? marker : 0), 0};
}

Eigen::Vector2d CalibrationBoard::size() const {
  if (kind != Kind::kAprilTagGrid) return {columns * square, rows * square};
  return {columns * (marker + gap) + gap, rows * (marker + gap) + gap};
}

bool CalibrationBoard::is_symmetric() const {
  return kind == Kind::kChessboard && (columns + rows) % 2 == 0;
}

std::vector<std::string> dictionary_names(Kind kind) {
  std::vector<std::string> names;
  for_each_dictionary(kind, [&](const NamedDictionary& one) { names.emplace_back(one.name); });
  return names;
}

cv::Ptr<cv::aruco::Dictionary> marker_dictionary(Kind kind, const std::string& name) {
  int id = -1;
  for_each_dictionary(kind, [&](const NamedDictionary& one) {
    if (name == one.name) id = one.id;
  });
  if (id < 0) {
    throw std::invalid_argument("there is no dictionary '" + name + "'" +
                                text::nearest_match_hint(name, dictionary_names(kind)));
  }
  return cv::aruco::getPredefinedDictionary(id);
}

cv::Ptr<cv::aruco::CharucoBoard> charuco_board(const CalibrationBoard& board) {
  return cv::aruco::CharucoBoard::create(
      board.columns, board.rows, static_cast<float>(board.square), static_cast<float>(board.marker),
      marker_dictionary(board.kind, board.dictionary));
}

namespace {

CalibrationBoard board_of(const YAML::Node& root, const std::filesystem::path& path) {
  text::YamlMap map(root, path, "board");
  CalibrationBoard board;
  if (!root["kind"]) map.fail("kind", "is missing", "Add chessboard, charuco or apriltag_grid");
  map.choose("kind",
             std::vector<std::pair<std::string, Kind>>{{"chessboard", Kind::kChessboard},
                                                       {"charuco", Kind::kCharuco},
                                                       {"apriltag_grid", Kind::kAprilTagGrid}},
             board.kind);
  map.read("columns", board.columns);
  map.read("rows", board.rows);
  map.read("square", board.square);
  map.read("marker", board.marker);
  map.read("gap", board.gap);
  map.read("dictionary", board.dictionary);
  map.finish();
  const bool grid = board.kind == Kind::kAprilTagGrid, plain = board.kind == Kind::kChessboard;
  const auto check_given = [&](const char* key, bool applies) {
    if (applies && !root[key]) map.fail(key, "is missing", "Add it as the board has it");
    if (!applies && root[key]) map.fail(key, "does not apply to this kind of board", "Remove it");
  };
  check_given("columns", true);
  check_given("rows", true);
  check_given("square", !grid);
  check_given("marker", !plain);
  check_given("gap", grid);
  check_given("dictionary", !plain);
  const int fewest = grid ? 1 : 3;
  for (const auto& [key, count] : {std::pair{"columns", board.columns}, {"rows", board.rows}}) {
    if (count < fewest || count > kMostColumns) {
      map.fail(key, fmt::format("is {}, not {} to {}", count, fewest, kMostColumns),
               grid ? "Count tags" : "Count squares, not corners");
    }
  }
  const auto check_length = [&](const char* key, double length) {
    if (!(length > 0 && length <= kLongest)) {
      map.fail(key, fmt::format("is {} m, not above 0 and up to {}", length, kLongest),
               "Give it in metres");
    }
  };
  if (!grid) check_length("square", board.square);
  if (!plain) check_length("marker", board.marker);
  if (grid) check_length("gap", board.gap);
  if (board.kind == Kind::kCharuco && board.marker > 0.95 * board.square) {
    map.fail("marker", "does not fit into a square with white round it",
             "Measure both sides on the board");
  }
  if (grid && board.gap > 0.5 * board.marker) {
    map.fail("gap", "is more than half of a tag", "Measure both on the board");
  }
  if (!plain) {
    try {
      const int have = marker_dictionary(board.kind, board.dictionary)->bytesList.rows;
      if (markers_of(board) > have) {
        map.fail("dictionary",
                 fmt::format("has {} markers, the board needs {}", have, markers_of(board)),
                 "Name the one that the board was printed with");
      }
    } catch (const std::invalid_argument& error) {
      map.fail("dictionary", "is unknown: " + std::string(error.what()),
               fmt::format("Write one of {}", fmt::join(dictionary_names(board.kind), ", ")));
    }
  }
  return board;
}

}  // namespace

CalibrationBoard read_calibration_board(const std::filesystem::path& path) {
  return board_of(text::load_yaml_map(path), path);
}

CalibrationBoard parse_calibration_board(const std::string& yaml,
                                         const std::filesystem::path& path) {
  return board_of(text::parse_yaml_map(yaml, path), path);
}

DrawnBoard draw_board(const CalibrationBoard& board, int pixels) {
  const bool grid = board.kind == Kind::kAprilTagGrid;
  if (pixels < 16) throw std::invalid_argument("a board is drawn with 16 pixels a square or more");
  if (double(pixels + 1) * board.columns * (pixels + 1) * board.rows * (grid ? 2.25 : 1) >
      kMostPixels) {
    throw std::invalid_argument("that many pixels make a board of more than 10^8");
  }
  DrawnBoard drawn;
  if (!grid) {
    drawn.scale = pixels / board.square;
    drawn.image = geometry::MaskImage(pixels * board.columns, pixels * board.rows, 255);
    if (board.kind == Kind::kCharuco) {
      cv::Mat image;
      charuco_board(board)->draw({drawn.image.width, drawn.image.height}, image, 0, 1);
      put(drawn.image, 0, 0, image);
      return drawn;
    }
    for (int row = 0; row < board.rows; ++row) {
      for (int column = row % 2; column < board.columns; column += 2) {
        fill(drawn.image, column * pixels, row * pixels, pixels, pixels, 0);
      }
    }
    return drawn;
  }
  const cv::Ptr<cv::aruco::Dictionary> dictionary = marker_dictionary(board.kind, board.dictionary);
  const int modules = dictionary->markerSize + 2;
  const int tag = (pixels + modules - 1) / modules * modules;
  drawn.scale = tag / board.marker;
  const auto place = [&](double metres) {
    return static_cast<int>(std::lround(metres * drawn.scale));
  };
  const Eigen::Vector2d size = board.size();
  drawn.image = geometry::MaskImage(place(size.x()), place(size.y()), 255);
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column) {
      const double x = column * (board.marker + board.gap), y = row * (board.marker + board.gap);
      const int u = place(x), v = place(y);
      fill(drawn.image, u, v, place(x + board.gap) - u, place(y + board.gap) - v, 0);
    }
  }
  for (int id = 0; id < board.columns * board.rows; ++id) {
    cv::Mat stamp;
    dictionary->drawMarker(id, tag, stamp, 1);
    const Eigen::Vector3d corner = board.corner_T(4 * id);
    put(drawn.image, place(corner.x()), place(corner.y()), stamp);
  }
  return drawn;
}

}  // namespace prehend::calibration
