#include "prehend/report/page.h"

#include <fstream>
#include <stdexcept>

#include "prehend/report/base64.h"
#include "prehend/report/escaped.h"
#include "prehend/report/figure_data.h"
#include "prehend/report/film.h"
#include "prehend/report/pictures.h"
#include "prehend/report/robot_figure.h"

namespace prehend::report {
namespace {

constexpr const char* kStyle = R"(
body{font:15px/1.5 "DejaVu Sans",system-ui,sans-serif;max-width:1080px;margin:24px auto;padding:0 16px;color:#222}
h1{font-size:24px}h2{font-size:18px;margin-top:32px;border-bottom:1px solid #ccc}
figure{display:inline-block;margin:6px 10px 6px 0;vertical-align:top}
figure img{max-width:342px;border:1px solid #ddd;image-rendering:auto}
figcaption{font-size:13px;color:#555;max-width:342px}
table{border-collapse:collapse;margin:8px 0}td,th{border:1px solid #ccc;padding:3px 10px;text-align:left}
td{overflow-wrap:anywhere;min-width:52px}
th{background:#f2f2f2}.verdict{padding:10px 14px;border-radius:4px;font-weight:bold}
.good{background:#e2f4e2;color:#165c16}.bad{background:#fbe3e1;color:#8b1a10}
.answer{background:#fdf3d3;color:#6b4e00}
.chart svg{max-width:100%;height:auto}
.scene,.robot{display:block;margin:8px 0}
.scene canvas,.robot canvas{display:block;border:1px solid #ddd;touch-action:none}
.scene div,.robot .view>div{display:flex;flex-wrap:wrap;gap:6px 14px;align-items:center;margin:6px 0}
.scene input[type=range]{flex:1 1 240px}.scene output{min-width:170px;font-size:13px}.scene figcaption,.robot figcaption{max-width:none}
.robot{display:grid;grid-template-columns:minmax(320px,1fr) minmax(320px,1fr);gap:6px 16px}
.robot .view,.robot .tree{min-width:0}.robot figcaption{grid-column:1/-1}.robot output{font-size:13px}
.robot .tree{max-height:560px;overflow:auto;border:1px solid #ddd;padding:6px 8px;font-size:13px}
.robot .tree details>details,.robot .tree details>div{margin-left:7px;border-left:1px solid #ddd;padding-left:5px}
.robot summary{cursor:pointer}.robot .tree button{font:inherit;border:0;background:none;padding:1px 4px;cursor:pointer}
.robot .tree button.marked{background:#f7dcc0}
.robot summary,.robot .tree div{white-space:nowrap}
.robot .joint{display:inline-flex;gap:6px;align-items:center;color:#555;cursor:default}
.robot .joint input{width:96px;margin:0}.robot .joint output{min-width:56px;color:#222}
@media(max-width:760px){.robot{grid-template-columns:1fr}}
.columns{display:grid;grid-template-columns:repeat(auto-fit,minmax(420px,1fr));gap:24px}
)";

}  // namespace

Page::Page(const std::string& title) : title_(title) {}

void Page::add_heading(const std::string& text) { body_ += "<h2>" + escaped(text) + "</h2>\n"; }

void Page::add_paragraph(const std::string& text) { body_ += "<p>" + escaped(text) + "</p>\n"; }

void Page::add_verdict(const std::string& text, bool success) {
  body_ += std::string("<p class=\"verdict ") + (success ? "good" : "bad") + "\">" + escaped(text) +
           "</p>\n";
}

void Page::add_answer(const std::string& text) {
  body_ += "<p class=\"verdict answer\">" + escaped(text) + "</p>\n";
}

void Page::add_pictures(const std::vector<geometry::ColorImage>& pictures,
                        const std::vector<std::string>& captions) {
  if (pictures.size() != captions.size()) {
    throw std::invalid_argument("every picture needs one caption");
  }
  body_ += "<div>\n";
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    body_ += "<figure><img alt=\"" + escaped(captions[i]) + "\" src=\"data:image/png;base64," +
             base64(encode_png(pictures[i])) + "\"><figcaption>" + escaped(captions[i]) +
             "</figcaption></figure>\n";
  }
  body_ += "</div>\n";
}

void Page::add_chart(const std::string& svg, const std::string& caption) {
  body_ += "<div class=\"chart\">" + svg + "<p>" + escaped(caption) + "</p></div>\n";
}

void Page::add_charts(const std::vector<std::string>& svgs, const std::string& caption) {
  body_ += "<div class=\"chart\">";
  for (const std::string& svg : svgs) body_ += svg;
  body_ += "<p>" + escaped(caption) + "</p></div>\n";
}

void Page::add_film(const Film& film, const std::string& caption) {
  add_figure("scene", film_json(film), caption);
}

void Page::add_robot(const RobotFigure& robot, const std::string& caption) {
  add_figure("robot", robot_figure_json(robot), caption);
}

void Page::add_figure(const char* kind, const std::string& json, const std::string& caption) {
  if (figure_program_.empty()) figure_program_ = figure_program();
  body_ += std::string("<figure class=\"") + kind + "\"><script type=\"application/json\">" + json +
           "</script><figcaption>" + escaped(caption) + "</figcaption></figure>\n";
}

void Page::add_table(const std::vector<std::string>& header,
                     const std::vector<std::vector<std::string>>& rows) {
  const auto add_row = [this](const std::vector<std::string>& cells, const char* tag) {
    body_ += "<tr>";
    for (const auto& cell : cells) {
      body_ += std::string("<") + tag + ">" + escaped(cell) + "</" + tag + ">";
    }
    body_ += "</tr>\n";
  };
  body_ += "<table>\n";
  add_row(header, "th");
  for (const auto& row : rows) {
    if (row.size() != header.size()) throw std::invalid_argument("a table's row has other columns");
    add_row(row, "td");
  }
  body_ += "</table>\n";
}

void Page::add_columns(const Page& left, const Page& right) {
  body_ += "<div class=\"columns\"><div>\n" + left.body_ + "</div><div>\n" + right.body_ +
           "</div></div>\n";
  for (const Page* page : {&left, &right}) {
    if (figure_program_.empty()) figure_program_ = page->figure_program_;
  }
}

std::string Page::html() const {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<title>" +
         escaped(title_) + "</title><style>" + kStyle + "</style></head>\n<body><h1>" +
         escaped(title_) + "</h1>\n" + body_ +
         (figure_program_.empty() ? ""
                                  : "<script type=\"module\">" + figure_program_ + "</script>\n") +
         "</body></html>\n";
}

void Page::write(const std::filesystem::path& file) const {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  std::ofstream out(file, std::ios::binary);
  out << html();
  out.flush();
  if (!out) {
    throw std::runtime_error("cannot write " + file.string() +
                             "; check that its folder can be written and the disk is not full");
  }
}

}  // namespace prehend::report
