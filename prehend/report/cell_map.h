#pragma once

#include <string>
#include <vector>

namespace prehend::report {

/// A table whose cells are coloured by what they say.
struct CellMap {
  enum class Kind { kGood, kLimit, kBad, kRefused };
  struct Cell {
    Kind kind = Kind::kGood;
    std::string text;  // short; it stands in the cell
    std::string hint;  // shown where a pointer rests on it
  };
  std::string title;
  std::string row_label, column_label;  // with unit
  std::vector<std::string> rows, columns;
  std::vector<Cell> cells;  // row by row
};

/// The map as an SVG element. @throws std::invalid_argument unless there is a cell for each row and
/// column.
std::string draw_cell_map(const CellMap& map);

/// Several as one SVG element, side by side in so many columns, row by row. The same throws, and
/// for columns < 1.
std::string draw_cell_maps(const std::vector<CellMap>& maps, int columns);

}  // namespace prehend::report
