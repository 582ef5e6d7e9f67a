#include "prehend/report/cell_map.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/report/escaped.h"

namespace prehend::report {
namespace {

// Pixels.
constexpr int kCellWidth = 74, kCellHeight = 26, kLeft = 90, kTop = 62, kMargin = 10;

const char* color_of(CellMap::Kind kind) {
  switch (kind) {
    case CellMap::Kind::kGood:
      return "#cdeccd";
    case CellMap::Kind::kLimit:
      return "#fbe3b0";
    case CellMap::Kind::kBad:
      return "#f4b8b8";
    case CellMap::Kind::kRefused:
      return "#dddddd";
  }
  throw std::invalid_argument("CellMap: a cell of no known kind");
}

std::string text_at(int x, int y, const char* anchor, const std::string& text) {
  return fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor,
                     escaped(text));
}

// Of one map, in pixels.
struct Size {
  int width = 0, height = 0;
};

Size size_of(const CellMap& map) {
  return {kLeft + static_cast<int>(map.columns.size()) * kCellWidth + kMargin,
          kTop + static_cast<int>(map.rows.size()) * kCellHeight + kMargin};
}

// Title, labels and cells, without the element around them.
std::string contents(const CellMap& map) {
  if (map.cells.size() != map.rows.size() * map.columns.size()) {
    throw std::invalid_argument(fmt::format("CellMap '{}' has {} cells for {} rows and {} columns",
                                            map.title, map.cells.size(), map.rows.size(),
                                            map.columns.size()));
  }
  const int columns = static_cast<int>(map.columns.size()),
            rows = static_cast<int>(map.rows.size());
  std::string svg = text_at(kMargin, 16, "start", map.title);
  svg += text_at(kLeft + columns * kCellWidth / 2, 36, "middle", map.column_label);
  svg += text_at(kLeft - 8, kTop - 8, "end", map.row_label);
  for (int c = 0; c < columns; ++c) {
    svg += text_at(kLeft + c * kCellWidth + kCellWidth / 2, kTop - 8, "middle",
                   map.columns[static_cast<std::size_t>(c)]);
  }
  for (int r = 0; r < rows; ++r) {
    const int y = kTop + r * kCellHeight;
    svg += text_at(kLeft - 8, y + 17, "end", map.rows[static_cast<std::size_t>(r)]);
    for (int c = 0; c < columns; ++c) {
      const CellMap::Cell& cell = map.cells[static_cast<std::size_t>(r * columns + c)];
      const int x = kLeft + c * kCellWidth;
      svg += fmt::format(
          "<g><title>{}</title><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\" "
          "stroke=\"white\"/>\n",
          escaped(cell.hint), x, y, kCellWidth, kCellHeight, color_of(cell.kind));
      svg += text_at(x + kCellWidth / 2, y + 17, "middle", cell.text) + "</g>\n";
    }
  }
  return svg;
}

}  // namespace

std::string draw_cell_map(const CellMap& map) { return draw_cell_maps({map}, 1); }

std::string draw_cell_maps(const std::vector<CellMap>& maps, int columns) {
  if (columns < 1) throw std::invalid_argument("draw_cell_maps: columns must be positive");
  int width = 0, height = 0, column_width = 0;
  for (const CellMap& map : maps) column_width = std::max(column_width, size_of(map).width);
  std::string inside;
  for (std::size_t first = 0; first < maps.size(); first += static_cast<std::size_t>(columns)) {
    int row_height = 0, x = 0;
    for (std::size_t i = first; i < maps.size() && i < first + static_cast<std::size_t>(columns);
         ++i) {
      inside +=
          fmt::format("<g transform=\"translate({} {})\">\n{}</g>\n", x, height, contents(maps[i]));
      row_height = std::max(row_height, size_of(maps[i]).height);
      x += column_width;
    }
    width = std::max(width, x);
    height += row_height;
  }
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"12\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n{2}</svg>\n",
      width, height, inside);
}

}  // namespace prehend::report
