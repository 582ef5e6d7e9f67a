#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/image.h"

namespace prehend::calibration {

/// A flat board whose corners cameras find. Frame T: origin at the upper left corner of what is
/// printed, x to the right along the columns, y down along the rows, z away from who looks at it.
struct CalibrationBoard {
  enum class Kind {
    kChessboard,    // black and white squares, the upper left one black
    kCharuco,       // a chessboard with markers in its white squares, as OpenCV 4.6 draws it
    kAprilTagGrid,  // AprilTags with black squares between their corners, as Kalibr's boards have
  };

  Kind kind = Kind::kCharuco;
  int columns = 0;         // squares; of a grid: tags
  int rows = 0;            // squares; of a grid: tags
  double square = 0;       // m, side of a square; not of a grid
  double marker = 0;       // m, side of a marker with its black border; not of a chessboard
  double gap = 0;          // m, between two tags; of a grid alone
  std::string dictionary;  // of markers; not of a chessboard

  /// Corners of the whole board; their ids are 0 to corners() - 1. Inner corners row by row from
  /// the upper left; of a grid the four of each tag clockwise from its upper left, tag by tag.
  int corners() const;
  /// @pre 0 <= id < corners()
  Eigen::Vector3d corner_T(int id) const;
  /// Width and height of what is printed [m].
  Eigen::Vector2d size() const;
  /// Turned by half a turn it looks the same: which corner is which remains unknown. True for a
  /// chessboard of an even number of columns and rows together.
  bool is_symmetric() const;
};

/// Names of dictionaries that a board of that kind may have: "5x5_100"; "36h11".
std::vector<std::string> dictionary_names(CalibrationBoard::Kind kind);

/// Reads {kind: chessboard|charuco|apriltag_grid, columns, rows, square, marker, gap, dictionary}.
/// @throws geometry::InputError "file:line: ...": unknown or missing keys, keys that do not apply
/// to the kind, lengths out of range, markers that do not fit, more markers than the dictionary
/// has.
CalibrationBoard read_calibration_board(const std::filesystem::path& path);
CalibrationBoard parse_calibration_board(const std::string& yaml,
                                         const std::filesystem::path& path);

/// The board as it is to be printed, without a white margin (a quiet zone of half a square is
/// needed on paper).
/// @param pixels a square's (tag's) side has, rounded so that modules have whole pixels; `scale`
/// of the result is pixels a metre. @throws std::invalid_argument for a bad board, fewer than 16
/// pixels or more than 10^8 in all.
struct DrawnBoard {
  geometry::MaskImage image;  // 0 black, 255 white
  double scale = 0;           // pixels / m
};
DrawnBoard draw_board(const CalibrationBoard& board, int pixels);

}  // namespace prehend::calibration
