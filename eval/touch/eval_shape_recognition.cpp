// A cube with a cross-shaped or a square hole between the pads (the soft-contact paper's figure 8):
// the tactile images show the shape, off-centre so that the two sides differ.

#include "eval/touch/experiment.h"
#include "eval/touch/imprints.h"
#include "prehend/report/pictures.h"
#include "prehend/simulation/tactile_sensor.h"
#include "prehend/simulation/work_cycle.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;
using namespace prehend::simulation;

Findings shape_recognition(const ExperimentOptions& options, report::Page& page) {
  Findings findings;
  findings.title = "shape recognition";
  std::vector<Row> rows;
  int right_answers = 0, questions = 0;
  bool sides_differ = true;
  for (const HoleShape shape : {HoleShape::kCross, HoleShape::kSquare}) {
    WorkCycleOptions cycle;
    cycle.grasp.law.viscous_friction = 0.1;
    cycle.grip_force = 12;
    cycle.step.step = options.quick ? 5e-3 : 1e-3;
    // 3.4 mm to one side and above the middle of the pad.
    cycle.shape =
        contact::Shape::mesh(perforated_cube(shape, cycle.grasp.box_size.x(), {0.0034, 0.006}));
    const WorkCycleResult result = run_work_cycle(cycle);
    const PhaseEnd& press = result.ends[static_cast<int>(CyclePhase::kPress)];
    sides_differ = sides_differ && press.left_image != press.right_image;
    for (const bool realistic : {false, true}) {
      std::vector<geometry::ColorImage> pictures;
      std::vector<std::string> captions;
      for (const bool left : {true, false}) {
        TactileSensorOptions sensor_options =
            realistic ? TactileSensorOptions::realistic() : TactileSensorOptions{};
        sensor_options.seed = left ? 1 : 2;
        TactileSensor sensor(sensor_options);
        TactileFrameReading frame;
        for (int i = 0; i < 15; ++i) {
          frame = sensor.sample(left ? press.left_image : press.right_image, 1.0 / 30);
        }
        const std::vector<double> image(frame.counts.begin(), frame.counts.end());
        double agreement[2];
        const HoleShape seen = recognise(image, 14, 6, 0.0034, agreement);
        ++questions;
        right_answers += seen == shape;
        rows.push_back({{"hole", std::string(to_string(shape))},
                        {"pad", std::string(left ? "left" : "right")},
                        {"realistic", realistic},
                        {"recognised_as", std::string(to_string(seen))},
                        {"agreement_with_cross", agreement[0]},
                        {"agreement_with_square", agreement[1]}});
        pictures.push_back(report::draw_tactile(image, 14, 6, 200));
        captions.push_back(left ? "left" : "right");
      }
      page.add_heading(std::string(to_string(shape)) + (realistic ? ", realistic pads" : ""));
      page.add_pictures(pictures, captions);
    }
  }
  add_table(page, rows);
  const bool all = right_answers == questions;
  page.add_verdict(std::to_string(right_answers) + " of " + std::to_string(questions) +
                       " imprints are told apart",
                   all);
  findings.summary = {{"recognised", static_cast<double>(right_answers)},
                      {"imprints", static_cast<double>(questions)},
                      {"sides_differ", sides_differ}};
  findings.tables = {{"imprints_seen", rows}};
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Shapes in tactile images", shape_recognition);
}
