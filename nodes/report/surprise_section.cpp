#include "nodes/report/surprise_section.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/convert/percepts.h"
#include "nodes/report/touch_section.h"
#include "prehend/report/charts.h"
#include "prehend/report/pictures.h"

namespace prehend::nodes {
namespace {

std::string said(const msgs::PerceptSurprise& surprise) {
  if (!(surprise.threshold() > 0)) return "of a hand to which no threshold was fitted";
  std::string senses;
  for (const msgs::SenseSurprise& sense : surprise.senses()) {
    if (sense.alarm()) senses += (senses.empty() ? " by " : ", ") + sense.sense();
  }
  return fmt::format("{} (more than {:.1f} of all together are one)",
                     surprise.alarm() ? "a surprise" + senses : "as expected",
                     surprise.threshold());
}

std::string bits_text(const msgs::PerceptSurprise& surprise) {
  const msgs::PossiblePercepts& likeliest = surprise.likeliest();
  std::string text = fmt::format(
      "Attempt {} at object {}: {:.1f} bits, {}; 0 is as expected, 10 "
      "are 1000 times less likely. Of what it might perceive, it comes nearest to that of the {}",
      surprise.attempt(), surprise.object_id(), surprise.bits(), said(surprise), likeliest.shape());
  if (likeliest.along() != 0 || likeliest.across() != 0) {
    text += fmt::format(" {:.1f} mm beside where it is believed to be",
                        1e3 * std::hypot(likeliest.along(), likeliest.across()));
  }
  return text + ".";
}

void add_bits(report::Page& page, const msgs::PerceptSurprise& surprise) {
  report::BarChart chart;
  chart.title = fmt::format("Bits by sense, attempt {}", surprise.attempt());
  chart.y_label = "bits";
  report::BarChart::Bars bits{"bits", {}}, thresholds{"an alarm above", {}};
  for (const msgs::SenseSurprise& sense : surprise.senses()) {
    chart.categories.push_back(sense.sense());
    bits.values.push_back(sense.bits());
    thresholds.values.push_back(sense.threshold());
  }
  if (chart.categories.empty()) return;
  chart.series = {bits};
  if (surprise.threshold() > 0) chart.series.push_back(thresholds);
  page.add_chart(report::draw_bar_chart(chart),
                 "How surprising what each sense said is. They do not add up to the whole, as they "
                 "share what may be perceived.");
  std::vector<const msgs::SenseSurprise*> parts;
  for (const msgs::SenseSurprise& part : surprise.parts()) parts.push_back(&part);
  std::stable_sort(parts.begin(), parts.end(),
                   [](const auto* a, const auto* b) { return a->bits() > b->bits(); });
  constexpr std::size_t kMostParts = 8;
  if (parts.size() > kMostParts) parts.resize(kMostParts);
  std::vector<std::vector<std::string>> rows;
  for (const msgs::SenseSurprise* part : parts) {
    rows.push_back({part->sense(), in_words(part->part()), fmt::format("{:.1f}", part->bits())});
  }
  if (!rows.empty()) page.add_table({"sense", "most surprising parts", "bits"}, rows);
}

const msgs::PerceivedPad* pad_named(const msgs::Percepts& percepts, const std::string& name) {
  for (const msgs::PerceivedPad& pad : percepts.pads()) {
    if (pad.name() == name) return &pad;
  }
  return nullptr;
}

double sum_of(const msgs::PadImage& image) {
  double sum = 0;  // N
  for (const float texel : image.texels()) sum += texel;
  return sum;
}

void add_pads(report::Page& page, const Collected& collected,
              const msgs::PerceptSurprise& surprise) {
  struct Shown {
    std::string pad, when;
    const msgs::PadImage* image;
  };
  std::vector<Shown> shown;
  double full = 0;  // N
  for (const msgs::PerceivedPad& pad : surprise.perceived().pads()) {
    const msgs::PerceivedPad* wanted = pad_named(surprise.likeliest().percepts(), pad.name());
    const auto frame = collected.pads.find(pad.name());
    const int texels = pad.closed().texels_size();
    if (wanted == nullptr || frame == collected.pads.end() || texels == 0 ||
        frame->second.intensity_size() != texels || wanted->closed().texels_size() != texels) {
      continue;
    }
    const std::vector<Shown> images{{pad.name(), "to be felt, closed", &wanted->closed()},
                                    {pad.name(), "felt, closed", &pad.closed()},
                                    {pad.name(), "to be felt, lifted", &wanted->lifted()},
                                    {pad.name(), "felt, lifted", &pad.lifted()}};
    const bool touches = std::any_of(images.begin(), images.end(),
                                     [](const Shown& one) { return sum_of(*one.image) > 0; });
    if (!touches) continue;
    for (const Shown& one : images) {
      if (one.image->texels_size() != texels) continue;
      shown.push_back(one);
      for (const float texel : one.image->texels()) full = std::max<double>(full, texel);
    }
  }
  std::vector<geometry::ColorImage> pictures;
  std::vector<std::string> captions;
  for (const Shown& one : shown) {
    const std::vector<double> texels(one.image->texels().begin(), one.image->texels().end());
    const msgs::TactileFrame& frame = collected.pads.at(one.pad);
    pictures.push_back(draw_pad(texels, one.pad, static_cast<int>(frame.rows()),
                                static_cast<int>(frame.columns()), collected, full));
    captions.push_back(
        fmt::format("{} pad, {}: {:.1f} N", in_words(one.pad), one.when, sum_of(*one.image)));
  }
  page.add_pictures(pictures, captions);
}

// Both side by side, in the same colours.
void add_view(report::Page& page, const msgs::PerceptSurprise& surprise) {
  const msgs::Percepts& wanted = surprise.likeliest().percepts();
  if (!surprise.perceived().has_view() || !wanted.has_view()) return;
  const belief::PerceivedView foretold = *convert::from_message(wanted).view;
  const belief::PerceivedView seen = *convert::from_message(surprise.perceived()).view;
  constexpr int kGap = 4, kWidth = 640;  // pixels
  const int columns = foretold.depth.width + kGap + seen.depth.width;
  const int scale = std::clamp(kWidth / columns, 1, 8);
  geometry::DepthImage both(scale * columns,
                            scale * std::max(foretold.depth.height, seen.depth.height),
                            std::numeric_limits<float>::quiet_NaN());
  const auto put = [&](const geometry::DepthImage& depth, int left) {
    for (int v = 0; v < scale * depth.height; ++v) {
      for (int u = 0; u < scale * depth.width; ++u) {
        both.at(scale * left + u, v) = depth.at(u / scale, v / scale);
      }
    }
  };
  put(foretold.depth, 0);
  put(seen.depth, foretold.depth.width + kGap);
  constexpr double kSquareCentimetre = 1e-4, kMillimetre = 1e-3;
  const double beside = (seen.center_C - foretold.center_C).norm();
  page.add_pictures(
      {report::color_values(both)},
      {fmt::format(
          "after the lift, to be seen (left) and seen by the camera: {:.0f} and {:.0f} cm2 "
          "of it, blue is near{}",
          foretold.area / kSquareCentimetre, seen.area / kSquareCentimetre,
          foretold.area > 0 && seen.area > 0
              ? fmt::format("; its middle is {:.1f} mm beside", beside / kMillimetre)
              : "")});
}

}  // namespace

void add_surprises(report::Page& page, const Collected& collected) {
  for (const msgs::PerceptSurprise& surprise : collected.percept_surprises) {
    page.add_paragraph(bits_text(surprise));
    add_bits(page, surprise);
    add_pads(page, collected, surprise);
    add_view(page, surprise);
  }
}

}  // namespace prehend::nodes
