// Blocks with different holes in two sides between the pads (the soft-contact paper's figure 8 and
// beyond): what the imprints show is learned from some presses, turned and shifted at random, and
// recognised in others; shapes that were not taught are refused.

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "eval/touch/experiment.h"
#include "eval/touch/imprints.h"
#include "eval/touch/pressing.h"
#include "prehend/report/pictures.h"
#include "prehend/touch/imprint_memory.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;
using prehend::touch::Imprint;

constexpr int kTaught = 12;                      // presses of each shape
constexpr int kKnown = 7;                        // of the shapes; the others are not taught
const Eigen::Vector3d kBlock(0.08, 0.04, 0.08);  // m
const Eigen::Vector2d kShift(0.003, 0.012);      // m, at most, of the block's middle
const std::array<Eigen::Vector2d, 2> kCenters{Eigen::Vector2d(0.0025, -0.0015),
                                              Eigen::Vector2d(-0.002, 0.003)};  // m, of the holes
const std::string kUnknown = "unknown";

struct Shown {
  std::array<std::vector<Imprint>, 2> imprints;  // of the sides at +y and -y
  Pressed first;
  double least_difference = INFINITY;  // of the two sides' frames, in deviations of their noise
};

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// How the two sides' frames differ at the same places of the block, over what one side's frames
// differ from one another. The pads face one another: their columns run against each other.
double difference_over_noise(const Pressed& pressed, int columns) {
  std::vector<double> sides, noise;
  for (std::size_t i = 0; i < pressed.frames[0].size(); ++i) {
    const std::size_t row = i / columns, column = i % columns;
    const std::size_t facing = row * columns + (columns - 1 - column);
    sides.push_back(1.0 * pressed.frames[0][i] - pressed.frames[1][facing]);
    for (const int side : {0, 1}) {
      noise.push_back(1.0 * pressed.frames[side][i] - pressed.again[side][i]);
    }
  }
  constexpr double kRounding = 0.41;  // counts, of the difference of two rounded values
  return root_mean_square(sides) / std::max(kRounding, root_mean_square(noise));
}

Shown press_block(Presser& presser, const contact::Shape& block, int presses,
                  std::mt19937& random) {
  std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi), unit(-1, 1);
  Shown shown;
  const int columns = presser.pad().layout.columns();
  while (static_cast<int>(shown.imprints[0].size()) < presses) {
    geometry::RigidTransform X_GB = geometry::RigidTransform::Identity();
    X_GB.linear() = Eigen::AngleAxisd(turn(random), Eigen::Vector3d::UnitY()).matrix();
    X_GB.translation() = Eigen::Vector3d(kShift.x() * unit(random), 0, kShift.y() * unit(random));
    const auto pressed = presser.press(block, X_GB);
    if (!pressed) throw std::runtime_error("a block was not pressed");
    if (shown.imprints[0].empty()) shown.first = *pressed;
    shown.least_difference =
        std::min(shown.least_difference, difference_over_noise(*pressed, columns));
    for (const int side : {0, 1}) {
      const std::vector<double> counts(pressed->frames[side].begin(), pressed->frames[side].end());
      const auto imprint = imprint_of(presser.pad(), felt_texels(presser.pad(), counts));
      if (!imprint) throw std::runtime_error("a block left no imprint");
      shown.imprints[side].push_back(*imprint);
    }
  }
  return shown;
}

geometry::ColorImage learned_picture(const touch::LearnedImprint& learned) {
  const int cells = learned.cells();
  std::vector<double> values;
  constexpr double kSeen = 0.3;  // texels
  for (int row = cells - 1; row >= 0; --row) {
    for (int column = 0; column < cells; ++column) {
      values.push_back(learned.known(row, column) > kSeen ? learned.likelihood(row, column) : 0.5);
    }
  }
  return report::draw_tactile(values, cells, cells, 1);
}

using Confusion = std::map<std::string, std::map<std::string, int>>;  // [shown][said]

void tell(const std::string& title, const Confusion& confusion, report::Page& page,
          Findings& findings, const std::string& table) {
  page.add_heading(title);
  std::vector<Row> rows;
  for (const Hole& hole : holes()) {
    Row row{{"shown", hole.name}};
    const auto& said = confusion.at(hole.name);
    for (int k = 0; k <= kKnown; ++k) {
      const std::string& name = k < kKnown ? holes()[k].name : kUnknown;
      const auto found = said.find(name);
      row.push_back({name, found == said.end() ? 0.0 : found->second});
    }
    rows.push_back(row);
  }
  add_table(page, rows);
  findings.tables.push_back({table, rows});
}

// Returns the share of right answers when asked with `together` presses at a time.
double ask_all(const touch::ImprintMemory& memory,
               const std::map<std::string, std::vector<Imprint>>& questions, int together,
               Confusion* confusion) {
  int right = 0, asked = 0;
  for (std::size_t h = 0; h < holes().size(); ++h) {
    const std::string& name = holes()[h].name;
    const std::vector<Imprint>& presses = questions.at(name);
    for (std::size_t i = 0; i + together <= presses.size(); i += together) {
      const auto begin = presses.begin() + static_cast<std::ptrdiff_t>(i);
      const auto answer = memory.ask({begin, begin + together});
      const std::string said = answer.name.empty() ? kUnknown : answer.name;
      ++(*confusion)[name][said];
      right += said == (h < kKnown ? name : kUnknown);
      ++asked;
    }
  }
  return static_cast<double>(right) / asked;
}

Findings shape_recognition(const ExperimentOptions& options, report::Page& page) {
  Findings findings;
  findings.title = "shape recognition";
  const int asked = options.quick ? 16 : 80;  // presses of each shape
  page.add_paragraph(fmt::format(
      "Five blocks, each with different holes in two sides, pressed by 20 N at any turn and up to "
      "{:.0f} and {:.0f} mm off the pads' middle. {} presses teach each of seven shapes; three are "
      "never taught. Nobody is told the shapes' drawings.",
      1e3 * kShift.x(), 1e3 * kShift.y(), kTaught));
  double least = 1, least_difference = INFINITY;
  for (const bool realistic : {false, true}) {
    const std::string pads = realistic ? "realistic" : "ideal";
    Presser presser({.realistic = realistic});
    std::mt19937 random(realistic ? 2 : 1);
    touch::ImprintMemory memory;
    std::map<std::string, std::vector<Imprint>> questions;
    std::vector<geometry::ColorImage> pictures, learned;
    std::vector<std::string> captions, names;
    for (std::size_t block = 0; block < holes().size() / 2; ++block) {
      const std::array<const Hole*, 2> sides{&holes()[2 * block], &holes()[2 * block + 1]};
      const contact::Shape shape = contact::Shape::mesh(
          perforated_block(kBlock, {sides[0], kCenters[0]}, {sides[1], kCenters[1]}));
      const Shown shown = press_block(presser, shape, kTaught + asked, random);
      least_difference = std::min(least_difference, shown.least_difference);
      for (const int side : {0, 1}) {
        const auto& imprints = shown.imprints[side];
        const auto end_of_taught = imprints.begin() + kTaught;
        questions[sides[side]->name] = {end_of_taught, imprints.end()};
        const std::vector<double> image(shown.first.frames[side].begin(),
                                        shown.first.frames[side].end());
        const double full = *std::max_element(image.begin(), image.end());
        pictures.push_back(report::draw_tactile(image, 14, 6, full));
        captions.push_back(sides[side]->name);
        if (2 * block + side >= kKnown) continue;
        memory.teach(sides[side]->name, {imprints.begin(), end_of_taught});
        learned.push_back(learned_picture(memory.faces().at(sides[side]->name)));
        names.push_back(sides[side]->name);
      }
    }
    page.add_heading("One press of each shape, " + pads + " pads");
    page.add_pictures(pictures, captions);
    page.add_heading(fmt::format("What {} presses taught, {} pads", kTaught, pads));
    page.add_pictures(learned, names);
    for (const int together : {1, 2, 4, 8}) {
      Confusion confusion;
      const double right = ask_all(memory, questions, together, &confusion);
      const std::string name = fmt::format("{}_{}", pads, together);
      findings.summary.push_back({"right_" + name, right});
      tell(fmt::format("{} pads, asked with {} press{}: {:.1f} % right", pads, together,
                       together > 1 ? "es" : "", 100 * right),
           confusion, page, findings, "confusion_" + name);
      if (together == 4) least = std::min(least, right);
    }
  }
  findings.summary.push_back({"least_difference_over_noise", least_difference});
  findings.summary.push_back({"sides_differ", least_difference >= 1});
  page.add_verdict(fmt::format("the two sides' frames differ by at least {:.1f} times the noise",
                               least_difference),
                   least_difference >= 1);
  page.add_verdict(
      fmt::format("asked with 4 presses, at least {:.1f} % are right, those that must be refused "
                  "among them (wanted: 95)",
                  100 * least),
      least >= 0.95);
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Shapes in tactile images", shape_recognition);
}
