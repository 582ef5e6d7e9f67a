#include "prehend/report/cell_map.h"

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

}  // namespace

std::string draw_cell_map(const CellMap& map) {
  if (map.cells.size() != map.rows.size() * map.columns.size()) {
    throw std::invalid_argument(fmt::format("CellMap '{}' has {} cells for {} rows and {} columns",
                                            map.title, map.cells.size(), map.rows.size(),
                                            map.columns.size()));
  }
  const int columns = static_cast<int>(map.columns.size()),
            rows = static_cast<int>(map.rows.size());
  const int width = kLeft + columns * kCellWidth + kMargin;
  const int height = kTop + rows * kCellHeight + kMargin;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"12\">\n",
      width, height);
  svg += fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"white\"/>\n", width, height);
  svg += text_at(kMargin, 16, "start", map.title);
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
  return svg + "</svg>\n";
}

}  // namespace prehend::report
