#include <cmath>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "prehend/calibration/calibrate_stereo.h"
#include "prehend/calibration/view_collection.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/image_files.h"
#include "prehend/report/charts.h"
#include "tools/calibrate/runs.h"

namespace prehend::tools {
namespace {

using calibration::BoardView;
using calibration::CameraFit;

// A line for each image: what it gave, and what is still missing with it.
void say_progress(std::size_t number, std::size_t of, const std::vector<BoardView>& views,
                  const BoardImages& images, int wanted) {
  calibration::CollectionGoal goal;
  goal.views = wanted;
  const std::vector<std::string> missing =
      calibration::still_missing(views, images.board(), images.width(), images.height(), goal);
  const BoardView& view = views.back();
  std::printf(
      "%zu of %zu  %s: %s; %s\n", number, of, view.name.c_str(),
      view.ids.empty()
          ? "board not found"
          : fmt::format("{} of {} corners", view.ids.size(), images.board().corners()).c_str(),
      missing.empty() ? "nothing is missing"
                      : fmt::format("missing: {}", fmt::join(missing, "; ")).c_str());
  std::fflush(stdout);
}

void say_camera(const CameraFit& fit) {
  const Eigen::Matrix3d& K = fit.calibration.K;
  int used = 0;
  for (const auto& view : fit.views) used += view.used;
  std::printf(
      "%s: fx %.3f +- %.3f, fy %.3f +- %.3f, cx %.3f +- %.3f, cy %.3f +- %.3f pixels; %.3f pixels "
      "of reprojection over %d of %zu views\n",
      fit.calibration.name.c_str(), K(0, 0), fit.fx_deviation, K(1, 1), fit.fy_deviation, K(0, 2),
      fit.cx_deviation, K(1, 2), fit.cy_deviation, fit.rms, used, fit.views.size());
  for (const auto& view : fit.views) {
    if (!view.used) std::printf("  left out: %s: %s\n", view.name.c_str(), view.why_not.c_str());
  }
  for (const std::string& remark : fit.remarks) std::printf("  %s\n", remark.c_str());
}

std::vector<std::vector<std::string>> camera_rows(const CameraFit& fit) {
  const auto row = [](const char* name, double value, double deviation) {
    return std::vector<std::string>{name, fmt::format("{:.4f}", value),
                                    fmt::format("{:.4f}", deviation)};
  };
  const Eigen::Matrix3d& K = fit.calibration.K;
  std::vector<std::vector<std::string>> rows{
      row("fx [pixels]", K(0, 0), fit.fx_deviation), row("fy [pixels]", K(1, 1), fit.fy_deviation),
      row("cx [pixels]", K(0, 2), fit.cx_deviation), row("cy [pixels]", K(1, 2), fit.cy_deviation)};
  static constexpr const char* kLens[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  for (std::size_t i = 0; i < fit.calibration.distortion.size() && i < 8; ++i) {
    rows.push_back({kLens[i], fmt::format("{:.6f}", fit.calibration.distortion[i]), ""});
  }
  return rows;
}

}  // namespace

void run_calibrate_camera(const CalibrateChoices& choices) {
  BoardImages images(choices.board);
  const std::vector<std::string> files = image_files(choices.inputs);
  std::vector<BoardView> views;
  for (const std::string& file : files) {
    views.push_back(images.find(file));
    say_progress(views.size(), files.size(), views, images, choices.views);
  }
  calibration::CameraOptions options;
  options.name = choices.name;
  options.coefficients = choices.coefficients;
  const CameraFit fit = calibration::calibrate_camera(views, images.board(), images.width(),
                                                      images.height(), options);
  say_camera(fit);
  const std::string page_name = page_file(choices);
  if (!page_name.empty()) {
    report::Page page("Calibration of " + fit.calibration.name);
    page.add_paragraph(fmt::format("{} x {} pixels; reprojection {:.3f} pixels root mean square.",
                                   images.width(), images.height(), fit.rms));
    for (const std::string& remark : fit.remarks) page.add_answer(remark);
    page.add_table({"", "value", "standard deviation"}, camera_rows(fit));
    add_camera_residuals(page, fit);
    write_page(page_name, page);
  }
  if (!choices.out.empty()) {
    write_result(choices.out, perception::camera_calibration_text(fit.calibration),
                 "The calibration");
  }
}

void run_calibrate_stereo(const CalibrateChoices& choices) {
  BoardImages left_images(choices.board), right_images(choices.board);
  const std::vector<std::string> left = image_files(choices.left);
  const std::vector<std::string> right = image_files(choices.right);
  if (left.size() != right.size()) {
    throw geometry::InputError(
        fmt::format("There are {} left and {} right images", left.size(), right.size()),
        "Give pairs: as many of both, in the same order of names");
  }
  std::vector<calibration::StereoView> views;
  std::vector<BoardView> left_views, right_views;
  for (std::size_t i = 0; i < left.size(); ++i) {
    calibration::StereoView view;
    view.left = left_images.find(left[i]);
    view.right = right_images.find(right[i]);
    left_views.push_back(view.left);
    right_views.push_back(view.right);
    views.push_back(view);
    say_progress(i + 1, left.size(), left_views, left_images, choices.views);
    say_progress(i + 1, left.size(), right_views, right_images, choices.views);
  }
  if (left_images.width() != right_images.width() ||
      left_images.height() != right_images.height()) {
    throw geometry::InputError("The left and the right images differ in size",
                               "Record both cameras at one size");
  }
  calibration::CameraOptions options;
  options.coefficients = choices.coefficients;
  const calibration::StereoFit fit = calibration::calibrate_stereo(
      views, left_images.board(), left_images.width(), left_images.height(), options);
  say_camera(fit.left);
  say_camera(fit.right);
  const Eigen::AngleAxisd turn(fit.calibration.X_RL.linear());
  std::printf(
      "together: baseline %.5f m, the cameras turned by %.4f degrees; %.3f pixels of reprojection "
      "over %zu pairs, rows %.3f pixels apart\n",
      fit.calibration.baseline(), turn.angle() * 180 / M_PI, fit.rms, fit.pairs.size(),
      fit.row_rms);
  std::string page_name = choices.report;
  if (page_name.empty() && !choices.out.empty()) {
    page_name = (std::filesystem::path(choices.out) / "residuals.html").string();
  }
  if (!page_name.empty()) {
    report::Page page("Calibration of a stereo pair");
    const Eigen::Vector3d t = fit.calibration.X_RL.translation();
    page.add_paragraph(fmt::format(
        "Right camera: p_R = R p_L + t, t = ({:.5f}, {:.5f}, {:.5f}) m, turned by {:.4f} degrees. "
        "Reprojection {:.3f} pixels; in the rectified pair rows differ by {:.3f} pixels.",
        t.x(), t.y(), t.z(), turn.angle() * 180 / M_PI, fit.rms, fit.row_rms));
    report::BarChart bars;
    bars.title = "Reprojection of each pair";
    bars.y_label = "root mean square [pixels]";
    bars.series = {{"left", {}}, {"right", {}}};
    for (const calibration::PairFit& pair : fit.pairs) {
      bars.categories.push_back(std::to_string(pair.view + 1));
      bars.series[0].values.push_back(pair.left_rms);
      bars.series[1].values.push_back(pair.right_rms);
    }
    page.add_chart(report::draw_bar_chart(bars), "Pairs by their number in the tables below.");
    for (const CameraFit* one : {&fit.left, &fit.right}) {
      page.add_heading("The " + one->calibration.name + " camera alone");
      page.add_table({"", "value", "standard deviation"}, camera_rows(*one));
      for (const std::string& remark : one->remarks) page.add_answer(remark);
      add_camera_residuals(page, *one);
    }
    write_page(page_name, page);
  }
  if (!choices.out.empty()) {
    const auto [left_file, right_file] = perception::camera_calibrations(fit.calibration);
    const std::filesystem::path folder(choices.out);
    write_result((folder / "left.yaml").string(), perception::camera_calibration_text(left_file),
                 "The left camera's calibration");
    write_result((folder / "right.yaml").string(), perception::camera_calibration_text(right_file),
                 "The right camera's calibration");
  }
}

void run_calibrate_board(const CalibrateChoices& choices) {
  const calibration::CalibrationBoard board = calibration::read_calibration_board(choices.board);
  const calibration::DrawnBoard drawn = calibration::draw_board(board, choices.pixels);
  // A white margin that detectors need round it.
  const int margin = choices.pixels / 2;
  geometry::ColorImage image(drawn.image.width + 2 * margin, drawn.image.height + 2 * margin,
                             {255, 255, 255});
  for (int v = 0; v < drawn.image.height; ++v) {
    for (int u = 0; u < drawn.image.width; ++u) {
      const std::uint8_t level = drawn.image.at(u, v);
      image.at(u + margin, v + margin) = {level, level, level};
    }
  }
  const std::filesystem::path path(choices.out);
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  perception::write_color_image(choices.out, image);
  std::printf(
      "%s: print it at %.2f dots an inch, without fitting it to the page; then measure it: "
      "the pattern must be %.4f m wide and %.4f m high\n",
      choices.out.c_str(), drawn.scale * 0.0254, board.size().x(), board.size().y());
}

}  // namespace prehend::tools
