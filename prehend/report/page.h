#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "prehend/geometry/image.h"

namespace prehend::report {

struct Film;
struct RobotFigure;

/// A self-contained HTML page: pictures and charts are inside the file.
class Page {
 public:
  explicit Page(const std::string& title);

  void add_heading(const std::string& text);
  void add_paragraph(const std::string& text);
  /// A paragraph that stands out: green for success, red otherwise.
  void add_verdict(const std::string& text, bool success);
  /// The same in amber: an answer that is neither, e.g. that nothing can be grasped.
  void add_answer(const std::string& text);
  /// Pictures side by side, each with its caption. Pictures and captions are as many.
  void add_pictures(const std::vector<geometry::ColorImage>& pictures,
                    const std::vector<std::string>& captions);
  /// An SVG element as drawn by draw_line_chart.
  void add_chart(const std::string& svg, const std::string& caption);
  /// The same of several, side by side where there is room, with one caption.
  void add_charts(const std::vector<std::string>& svgs, const std::string& caption);
  /// Bodies to be turned by pointer and touch, and played; a browser needs WebGL for it.
  /// @throws as film_json() and figure_program().
  void add_film(const Film& film, const std::string& caption);
  /// A robot whose joints move by sliders; the same holds. @throws as robot_figure_json() and
  /// figure_program().
  void add_robot(const RobotFigure& robot, const std::string& caption);
  /// `rows` have as many cells as `header`.
  void add_table(const std::vector<std::string>& header,
                 const std::vector<std::vector<std::string>>& rows);
  /// What is on two pages, side by side; below one another where there is no room.
  void add_columns(const Page& left, const Page& right);

  /// The whole page.
  std::string html() const;
  /// Writes the page, making its folder. @throws std::runtime_error naming the file.
  void write(const std::filesystem::path& file) const;

 private:
  void add_figure(const char* kind, const std::string& json, const std::string& caption);

  std::string title_;
  std::string body_;
  std::string figure_program_;  // once for all figures
};

}  // namespace prehend::report
