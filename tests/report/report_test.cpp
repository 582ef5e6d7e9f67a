#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/report/cell_map.h"
#include "prehend/report/charts.h"
#include "prehend/report/film.h"
#include "prehend/report/front_chart.h"
#include "prehend/report/page.h"
#include "prehend/report/pictures.h"
#include "prehend/report/rejections.h"
#include "prehend/report/robot_figure.h"
#include "prehend/report/section.h"

namespace prehend::report {
namespace {

using geometry::ColorImage;
using geometry::Rgb;
using geometry::RigidTransform;
using testing::HasSubstr;
using testing::Not;

TEST(Page, EscapesTextAndHoldsItsPictures) {
  Page page("a <b> & \"c\"");
  page.add_paragraph("<script>alert(1)</script>");
  page.add_pictures({ColorImage(4, 4, {255, 0, 0})}, {"red"});
  page.add_table({"stage", "seconds"}, {{"a", "1"}, {"b", "2"}});
  EXPECT_THAT(page.html(), Not(HasSubstr("<script>")));
  EXPECT_THAT(page.html(), HasSubstr("a &lt;b&gt; &amp; &quot;c&quot;"));
  EXPECT_THAT(page.html(), HasSubstr("data:image/png;base64,iVBORw0KGgo"));  // PNG's magic
  EXPECT_THAT(page.html(), HasSubstr("<td>b</td><td>2</td>"));
  EXPECT_THROW(page.add_table({"one"}, {{"1", "2"}}), std::invalid_argument);
  EXPECT_THROW(page.add_pictures({}, {"no picture"}), std::invalid_argument);
}

// Of 90 + 74 n + 10 by 62 + 26 m + 10 pixels each: the wider of a column, the higher of a row.
TEST(CellMap, MapsStandSideBySideInOnePicture) {
  const CellMap wide{"wide", "", "", {"r"}, {"a", "b"}, {{}, {}}};
  const CellMap high{"high", "", "", {"r", "s"}, {"c"}, {{}, {}}};
  const std::string three = draw_cell_maps({wide, high, high}, 2);
  EXPECT_THAT(three, HasSubstr("viewBox=\"0 0 496 248\""));
  EXPECT_THAT(three, HasSubstr("translate(248 0)"));
  EXPECT_THAT(three, HasSubstr("translate(0 124)"));
  EXPECT_THAT(draw_cell_map(wide), HasSubstr("viewBox=\"0 0 248 98\""));
  EXPECT_THROW(draw_cell_maps({wide}, 0), std::invalid_argument);
  EXPECT_THROW(draw_cell_map({"no cell", "", "", {"r"}, {"c"}, {}}), std::invalid_argument);
}

TEST(Page, SaysWhichFileCannotBeWritten) {
  try {
    Page("x").write("/proc/no-such-folder/report.html");
    FAIL() << "written to /proc";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/proc/no-such-folder/report.html"));
  }
}

TEST(FrontChart, SaysAndDrawsWhatWasChosen) {
  DrawnFront front;
  front.subject = "shape";
  front.error_name = "distance of the truth";
  front.error_unit = "m";
  front.points = {{0.02, 0.003, 0}, {0.06, 0.002, 0}};
  front.chosen = 1;
  front.tolerance = 0.0025;
  front.measured = "60 ms, 2.00 mm";
  front.knobs = "thinning 0.04";
  EXPECT_EQ(front_text(front),
            "A tolerance of 2.5 mm chose from the measured front of 'shape', 2 settings: 60 ms, "
            "2.00 mm (thinning 0.04).");
  Page page("front");
  add_front(page, front);
  EXPECT_THAT(page.html(), HasSubstr("error [mm]"));
  EXPECT_THAT(page.html(), HasSubstr(">chosen<"));
  EXPECT_THAT(page.html(), Not(HasSubstr("meshes")));  // of which it does not tell
  front.chosen = 2;
  EXPECT_THROW(add_front(page, front), std::invalid_argument);
}

// A front of one setting has nothing beside the one that is chosen.
TEST(FrontChart, DrawsASinglePoint) {
  DrawnFront front;
  front.subject = "chain";
  front.error_unit = "of views";
  front.points = {{1.4, 0.25, 0.007}};
  front.budget = 2;
  Page page("front");
  add_front(page, front);
  EXPECT_THAT(page.html(), HasSubstr("error [% of views]"));
  EXPECT_THAT(page.html(), HasSubstr("error of the meshes [mm]"));
}

TEST(Charts, DrawSeriesWithGapsAndHostileNames) {
  LineChart chart{
      "it's 'quoted'", "t [s]", "F [N]", {{"left'; system('false')", {}}}, {{0.5, "m"}}};
  for (int i = 0; i < 100; ++i) {
    chart.series[0].points.emplace_back(i * 0.01, i == 50 ? NAN : std::sin(i * 0.1));
  }
  const std::string svg = draw_line_chart(chart);
  EXPECT_EQ(svg.rfind("<svg", 0), 0u);
  EXPECT_THAT(svg, HasSubstr("F [N]"));
  chart.series[0].points.clear();
  EXPECT_THROW(draw_line_chart(chart), std::runtime_error);
}

TEST(Charts, DrawErrorBarsMarksAndBars) {
  LineChart chart{"deviation", "x", "y", {{"bars", {{0, 1}, {1, 2}}, {0.1, 0.2}}}, {}};
  const std::string with_bars = draw_line_chart(chart);
  chart.series[0].deviations.clear();
  EXPECT_NE(with_bars, draw_line_chart(chart));
  chart.series[0].connected = false;
  EXPECT_THAT(draw_line_chart(chart), HasSubstr("</svg>"));

  BarChart bars{
      "b", "mm", {"a mug", "it's \"x\""}, {{"Ours", {1, NAN}, {0.5, NAN}}, {"Del", {3, 4}}}};
  const std::string svg = draw_bar_chart(bars);
  EXPECT_THAT(svg, HasSubstr("a mug"));
  EXPECT_THAT(svg, HasSubstr("Ours"));
  bars.series[1].values.pop_back();
  EXPECT_THROW(draw_bar_chart(bars), std::runtime_error);
  // Bits that are fewer than expected: all bars hang down.
  bars.series = {{"bits", {-3, -10}}};
  EXPECT_THAT(draw_bar_chart(bars), AllOf(HasSubstr("bits"), HasSubstr(">-10<")));
  bars.series = {{"nothing", {NAN, NAN}}};
  EXPECT_THROW(draw_bar_chart(bars), std::runtime_error);
}

TEST(Charts, StackedBarsNameEachCategoryAndItsSum) {
  const BarChart chart{"where they fell",
                       "candidates",
                       {"wider than the gripper opens", "it's in the table"},
                       {{"circles", {340, 12}}, {"boxes", {17, 0}}}};
  const std::string svg = draw_stacked_bars(chart);
  for (const char* text : {"wider than the gripper opens", "it's in the table", ">357<", ">12<",
                           "circles", "boxes", "candidates"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  BarChart wrong = chart;
  wrong.series[0].values.pop_back();
  EXPECT_THROW(draw_stacked_bars(wrong), std::runtime_error);
}

// They stood in one sentence, up to a dozen of them.
TEST(Rejections, AreBarsAndATable) {
  Page page("t");
  add_rejections(page, {}, 5, "candidates");
  EXPECT_THAT(page.html(), Not(HasSubstr("<table>")));
  add_rejections(page,
                 {{"too wide", "circles", 340, "74.0 mm > 69.0 mm"},
                  {"turns", "circles", 2, ""},
                  {"too wide", "boxes", 17, "80.0 mm > 69.0 mm"}},
                 400, "candidates");
  const std::string html = page.html();
  EXPECT_THAT(html, HasSubstr("359 of 400 candidates fell."));
  EXPECT_THAT(html, HasSubstr("<svg"));
  EXPECT_THAT(html, HasSubstr(">357<"));  // of both generators
  EXPECT_THAT(html, HasSubstr("<td>340</td><td>too wide</td><td>circles</td>"
                              "<td>74.0 mm &gt; 69.0 mm</td>"));
}

TEST(Pictures, NearPointsHideFarOnes) {
  geometry::PointCloud cloud;
  cloud.points = {{0, 0, 2}, {0, 0, 1}, {0, 0, -1}, {NAN, NAN, NAN}};
  const std::vector<Rgb> colors = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {0, 0, 0}};
  const auto camera = picture_camera(11, 11);
  const ColorImage image =
      draw_cloud(cloud, colors, camera, geometry::RigidTransform::Identity(), 1);
  EXPECT_EQ(image.at(5, 5), (Rgb{0, 255, 0}));
  EXPECT_EQ(image.at(0, 0), (Rgb{255, 255, 255}));
  EXPECT_THROW(draw_cloud(cloud, {}, camera, geometry::RigidTransform::Identity()),
               std::invalid_argument);
}

TEST(Pictures, OrbitShowsTheWholeBallInTheMiddle) {
  const Eigen::Vector3d center(0.3, 0.2, 0.1);
  const auto camera = picture_camera(101, 101);
  const auto X_WC = orbit(center, 0.1, 0.7, 0.5);
  geometry::TriangleMesh ball = geometry::make_sphere(0.1, 48);
  for (auto& v : ball.vertices) v += center;
  const ColorImage image = draw_meshes({{ball, {10, 200, 10}}}, camera, X_WC);
  int painted = 0;
  for (int i = 0; i < 101; ++i) {
    EXPECT_EQ(image.at(i, 0), (Rgb{255, 255, 255}));  // nothing touches the border
    EXPECT_EQ(image.at(0, i), (Rgb{255, 255, 255}));
    painted += image.at(i, 50) != Rgb{255, 255, 255};
  }
  EXPECT_GT(painted, 50);
  EXPECT_NE(image.at(50, 50), (Rgb{255, 255, 255}));
}

Film two_frames() {
  Film film;
  film.times = {1, 1.5};
  film.captions = {"reach", "lift </script>"};
  FilmBody body{"object <0>", {40, 110, 190}, 1, geometry::make_box({0.1, 0.1, 0.2}), {}};
  body.mesh_B.vertices.emplace_back(9, 9, 9);  // of no triangle
  RigidTransform X = RigidTransform::Identity();
  body.X_WB.push_back(X);
  X.translation() = Eigen::Vector3d(0, 0, 0.25);
  body.X_WB.push_back(X);
  film.bodies = {body, {"table", {1, 2, 3}, 0.5, geometry::make_box({1, 1, 0.1}), {X}}};
  return film;
}

TEST(Film, SaysBodiesAndPosesAndEndsNoScript) {
  const std::string json = film_json(two_frames());
  EXPECT_EQ(json.find('<'), std::string::npos);
  EXPECT_THAT(json, HasSubstr(R"("times":[1.0,1.5])"));
  EXPECT_THAT(json, HasSubstr(R"("lift \u003c/script>")"));
  EXPECT_THAT(json, HasSubstr(R"("color":"#286ebe")"));
  // 8 corners of three float32: 96 bytes are 128 letters; a pose has seven numbers.
  const auto letters = [&json](const std::string& name) {
    const auto begin = json.find("\"" + name + "\":\"") + name.size() + 4;
    return json.find('"', begin) - begin;
  };
  EXPECT_EQ(letters("vertices"), 128u);
  EXPECT_EQ(letters("triangles"), 192u);
  EXPECT_EQ(letters("poses"), 76u);
}

TEST(RobotFigure, SaysWhatMovesWhatAndEndsNoScript) {
  RobotFigure figure;
  figure.links = {{"palm </script>", ""}, {"finger", ""}};
  RobotFigure::Joint joint;
  joint.kind = RobotFigure::Joint::Kind::kRevolute;
  joint.child = 1;
  joint.upper = 1.5;
  figure.joints = {joint};
  figure.meshes = {geometry::make_box({0.1, 0.1, 0.2})};
  figure.shapes = {{.link = 1, .mesh = 0, .layer = "seen", .color = {40, 110, 190}}};
  figure.postures = {{"open", {{0, 0.5}}}};
  const std::string json = robot_figure_json(figure);
  EXPECT_EQ(json.find('<'), std::string::npos);
  EXPECT_THAT(json,
              HasSubstr(R"("kind":"revolute","parent":0,"child":1,"pose":[0.0,0.0,0.0,1.0,)"));
  EXPECT_THAT(json, HasSubstr(R"("lower":null,"upper":1.5)"));
  EXPECT_THAT(json, HasSubstr(R"("layer":"seen","color":"#286ebe")"));

  const auto refused = [&](auto change) {
    RobotFigure changed = figure;
    change(changed);
    try {
      robot_figure_json(changed);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_THAT(refused([](auto& f) { f.links.clear(); }), HasSubstr("there must be links"));
  EXPECT_THAT(refused([](auto& f) { f.joints[0].child = 2; }), HasSubstr("no such link"));
  EXPECT_THAT(refused([](auto& f) { f.joints.push_back(f.joints[0]); }), HasSubstr("two joints"));
  EXPECT_THAT(refused([](auto& f) { f.joints[0].parent = 1; }), HasSubstr("hangs on itself"));
  EXPECT_THAT(refused([](auto& f) { f.joints[0].leader = 1; }), HasSubstr("no leader"));
  EXPECT_THAT(refused([](auto& f) { f.joints[0].upper = NAN; }), HasSubstr("not finite"));
  EXPECT_THAT(refused([](auto& f) { f.shapes[0].mesh = 1; }), HasSubstr("no link or mesh"));
  EXPECT_THAT(refused([](auto& f) { f.meshes[0].triangles[0].x() = 99; }),
              HasSubstr("no such corner"));
  EXPECT_THAT(refused([](auto& f) { f.postures[0].positions[0].first = 1; }),
              HasSubstr("posture 'open'"));
}

TEST(Film, IsRefusedWhereItCannotBePlayed) {
  const auto refused = [](auto change) {
    Film film = two_frames();
    change(film);
    try {
      film_json(film);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(refused([](Film&) {}), "taken");
  EXPECT_THAT(refused([](Film& f) { f.times[1] = 1; }), HasSubstr("times must increase"));
  EXPECT_THAT(refused([](Film& f) { f.captions.pop_back(); }), HasSubstr("caption"));
  EXPECT_THAT(refused([](Film& f) { f.bodies.clear(); }), HasSubstr("frames and bodies"));
  EXPECT_THAT(refused([](Film& f) { f.bodies[0].X_WB.push_back(f.bodies[0].X_WB[0]); }),
              HasSubstr("one for each frame"));
  EXPECT_THAT(refused([](Film& f) { f.bodies[1].opacity = 0; }), HasSubstr("body 'table'"));
  EXPECT_THAT(refused([](Film& f) { f.bodies[0].X_WB[0].translation().x() = NAN; }),
              HasSubstr("a pose is not finite"));
  EXPECT_THAT(refused([](Film& f) { f.bodies[0].mesh_B.vertices[0].x() = NAN; }),
              HasSubstr("a vertex is not finite"));
  EXPECT_THAT(refused([](Film& f) { f.bodies[0].mesh_B.triangles[0].x() = 99; }),
              HasSubstr("no such corner"));
}

TEST(Film, ItsProgramStandsInThePageOnce) {
  Page page("t");
  EXPECT_EQ(page.html().find("<script"), std::string::npos) << "a page without films has none";
  page.add_film(two_frames(), "first & foremost");
  page.add_film(two_frames(), "second");
  const std::string html = page.html();
  EXPECT_THAT(html, HasSubstr("first &amp; foremost"));
  const std::string module = "<script type=\"module\">";
  EXPECT_EQ(html.find(module), html.rfind(module));
  EXPECT_NE(html.find(module), std::string::npos);
  // Nothing within a script ends it: as many begin as end.
  const auto count = [&html](const std::string& what) {
    int found = 0;
    for (auto at = html.find(what); at != std::string::npos; at = html.find(what, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("</script"), 3);
  Page beside("u");
  beside.add_columns(page, Page("v"));
  EXPECT_THAT(beside.html(), HasSubstr(module));
}

TEST(Section, IsWhereThePlaneCuts) {
  const auto box = geometry::make_box({0.2, 0.1, 0.3});
  double length = 0;
  Eigen::AlignedBox2d around;
  for (const auto& [a, b] : section_of(box, {{0, 0, 0.05}, {1, 0, 0}, {0, 1, 0}})) {
    length += (b - a).norm();
    around.extend(a);
    around.extend(b);
  }
  EXPECT_NEAR(length, 0.6, 1e-12) << "round the box";
  EXPECT_LT((around.sizes() - Eigen::Vector2d(0.2, 0.1)).norm(), 1e-12);
  EXPECT_TRUE(section_of(box, {{0, 0, 0.5}, {1, 0, 0}, {0, 1, 0}}).empty());
  // Through vertices and along edges and faces: it is closed, or there is none.
  const auto through = section_of(box, {{0, 0, 0}, {0.894427191, 0.447213595, 0}, {0, 0, 1}});
  length = 0;
  for (const auto& [a, b] : through) length += (b - a).norm();
  EXPECT_NEAR(length, 2 * (0.3 + std::hypot(0.2, 0.1)), 1e-6);
  EXPECT_THROW(section_of(box, {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}), std::invalid_argument);
  EXPECT_THROW(section_of(box, {{NAN, 0, 0}, {1, 0, 0}, {0, 1, 0}}), std::invalid_argument);
}

TEST(Section, IsDrawnWithItsScale) {
  const auto box = geometry::make_box({0.2, 0.1, 0.3});
  const std::string svg = draw_section("a <box>", {{"true & bare", {40, 40, 40}, &box}}, {});
  EXPECT_THAT(svg, HasSubstr("a &lt;box&gt;"));
  EXPECT_THAT(svg, HasSubstr("true &amp; bare"));
  EXPECT_THAT(svg, HasSubstr("100 mm")) << "the longest round length within 40 % of 300 mm";
  EXPECT_THAT(svg, HasSubstr("stroke=\"#282828\""));
  EXPECT_THAT(draw_section("t", {{"none", {}, &box}}, {{0, 9, 0}, {1, 0, 0}, {0, 0, 1}}),
              HasSubstr("cuts nothing"));
}

TEST(Pictures, ValuesMasksAndTactileImages) {
  geometry::Image<float> values(3, 1, NAN);
  EXPECT_EQ(color_values(values).at(0, 0), (Rgb{0, 0, 0}));
  values.at(0, 0) = 2;
  values.at(1, 0) = 1;
  const ColorImage colored = color_values(values);
  EXPECT_GT(colored.at(0, 0)[0], colored.at(0, 0)[2]);  // high is red
  EXPECT_EQ(colored.at(2, 0), (Rgb{0, 0, 0}));

  ColorImage image(20, 20, {0, 0, 0});
  geometry::MaskImage mask(20, 20, 0);
  for (int v = 5; v < 15; ++v) {
    for (int u = 5; u < 15; ++u) mask.at(u, v) = 255;
  }
  const ColorImage overlay = overlay_masks(image, {mask});
  EXPECT_EQ(overlay.at(0, 0), (Rgb{0, 0, 0}));
  EXPECT_EQ(overlay.at(5, 5), category_color(0));
  EXPECT_THROW(overlay_masks(image, {geometry::MaskImage(3, 3)}), std::invalid_argument);

  const ColorImage pad = draw_tactile({0, 1}, 1, 2, 1.0, 10);
  EXPECT_EQ(pad.at(15, 5), (Rgb{255, 255, 255}));
  EXPECT_LT(pad.at(5, 5)[0], 30);
  EXPECT_THROW(draw_tactile({0}, 1, 2, 1.0), std::invalid_argument);
  // Two cells over one another, the upper one pressed; the gap between them is no cell.
  const ColorImage cells = draw_cells({{{0, 0.03}, 0.01, 1}, {{0, 0}, 0.01, 0}}, 1.0, 40);
  EXPECT_EQ(cells.width, 10);
  EXPECT_EQ(cells.height, 40);
  EXPECT_EQ(cells.at(4, 4), (Rgb{255, 255, 255})) << "y is up";
  EXPECT_LT(cells.at(4, 34)[0], 30);
  EXPECT_EQ(cells.at(4, 20), (Rgb{70, 70, 70}));
  EXPECT_THROW(draw_cells({}, 1.0), std::invalid_argument);
  EXPECT_THROW(draw_cells({{{0, 0}, 0, 1}}, 1.0), std::invalid_argument);
  EXPECT_THROW(encode_png(ColorImage{}), std::runtime_error);
}

}  // namespace
}  // namespace prehend::report
