#include "eval/belief/touch_trial.h"

#include <memory>

#include <yaml-cpp/yaml.h>

#include "eval/belief/belief_truth.h"
#include "eval/belief/predicted_case.h"
#include "eval/gaussian_surface.h"
#include "eval/processor_time.h"
#include "prehend/belief/object_belief.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/model.h"

namespace prehend::eval {
namespace {

std::unique_ptr<Toucher> make_toucher(const Case& one, const TouchTrialOptions& options) {
  if (options.hand) return std::make_unique<HandToucher>(*options.hand, options.noise, one.seed);
  return std::make_unique<FingertipToucher>(options.noise, one.seed);
}

/// The seen points of a shape, with normals.
geometry::PointCloud seen_points(const shape::CompletedShape& shape, const geometry::Plane& table) {
  const surface::ShapeCloud all = surface::shape_cloud(shape, table);
  geometry::PointCloud seen;
  for (std::size_t i = 0; i < all.cloud_W.size(); ++i) {
    if (all.basis[i] != surface::SurfaceOrigin::kSeen) continue;
    seen.points.push_back(all.cloud_W.points[i]);
    seen.normals.push_back(all.cloud_W.normals[i]);
  }
  return seen;
}

std::vector<TriedShape> try_shapes(const shape::CompletedShape& shape, const geometry::Plane& table,
                                   const BeliefTruth& truth, std::uint64_t seed) {
  const belief::ObjectBelief belief(shape, table);
  std::vector<TriedShape> shapes;
  for (std::size_t i = 0; i < belief.shapes().size(); ++i) {
    BeliefStep step;
    try {
      truth.measure(belief.mesh(i), seed, &step);
    } catch (const geometry::InputError&) {
      continue;  // without a surface it is none
    }
    shapes.push_back({belief.shapes()[i].prior_terms, step.unseen});
  }
  return shapes;
}

/// @param baseline gets what the baseline makes of the same evidence, unless null.
BeliefSeries run_series(const shape::CompletedShape& shape, const geometry::Plane& table, Told told,
                        const BeliefTruth& truth, const Case& one, const TouchTrialOptions& options,
                        BeliefSeries* baseline) {
  const geometry::PointCloud seen = baseline ? seen_points(shape, table) : geometry::PointCloud();
  BeliefSeries series;
  series.name = told == Told::kContacts ? "contacts" : "contacts and empty space";
  belief::ObjectBelief belief(shape, table);
  const std::unique_ptr<Toucher> toucher = make_toucher(one, options);
  for (int touches = 0; touches <= options.touches; ++touches) {
    BeliefStep step;
    step.touches = touches;
    if (touches > 0) {
      series.problem = toucher->touch(truth.query(), told, &belief);
      if (!series.problem.empty()) break;
    }
    const double start = processor_time();
    belief.update();
    const geometry::TriangleMesh mesh = belief.mesh();
    step.seconds = processor_time() - start;
    step.weight = belief.shapes().front().weight;
    step.misfit = belief.shapes().front().misfit;
    truth.measure(mesh, one.seed, &step);
    series.steps.push_back(step);
    if (!baseline) continue;
    BeliefStep other;
    other.touches = touches;
    const double baseline_start = processor_time();
    const geometry::TriangleMesh gaussian =
        gaussian_surface(seen, belief.contacts(), belief.swept(), table, belief.swept().box());
    other.seconds = processor_time() - baseline_start;
    truth.measure(gaussian, one.seed, &other);
    baseline->steps.push_back(other);
  }
  return series;
}

}  // namespace

BeliefCase belief_case_of(const Case& one) {
  BeliefCase result;
  result.case_name = one.name();
  result.group = one.data_set->group;
  result.data_set = one.data_set->name;
  result.orientation = one.orientation;
  return result;
}

BeliefCase run_touch_trial(const Case& one, const TouchTrialOptions& options) {
  BeliefCase result = belief_case_of(one);
  try {
    const PredictedCase predicted = predict_case(one);
    const shape::CompletedShape& shape = predicted.shape;
    const geometry::Plane& table = predicted.support_W;
    const BeliefTruth truth(one, predicted.viewpoint_W);
    if (truth.is_all_seen()) {
      throw geometry::InputError("All of it was seen", "Look from elsewhere");
    }
    BeliefSeries prediction{kPredictionSeries, "", {{}}};
    truth.measure(surface::make_object_model(shape, table).mesh_W, one.seed,
                  &prediction.steps.front());
    result.shapes = try_shapes(shape, table, truth, one.seed);
    BeliefSeries baseline{"Gaussian process, the same evidence", "", {}};
    result.series.push_back(prediction);
    result.series.push_back(
        run_series(shape, table, Told::kContacts, truth, one, options, nullptr));
    result.series.push_back(run_series(shape, table, Told::kEmpty, truth, one, options,
                                       options.hand ? nullptr : &baseline));
    if (!options.hand) result.series.push_back(baseline);
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

namespace {

struct StepFigure {
  const char* name;
  double BeliefStep::*value;
};
constexpr StepFigure kStepFigures[] = {
    {"unseen", &BeliefStep::unseen},   {"chamfer", &BeliefStep::chamfer},
    {"jaccard", &BeliefStep::jaccard}, {"weight", &BeliefStep::weight},
    {"misfit", &BeliefStep::misfit},   {"seconds", &BeliefStep::seconds}};

}  // namespace

std::string to_text(const BeliefCase& result) {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::BeginMap;
  out << YAML::Key << "case" << YAML::Value << YAML::DoubleQuoted << result.case_name;
  out << YAML::Key << "group" << YAML::Value << YAML::DoubleQuoted << result.group;
  out << YAML::Key << "data_set" << YAML::Value << YAML::DoubleQuoted << result.data_set;
  out << YAML::Key << "orientation" << YAML::Value << result.orientation;
  out << YAML::Key << "problem" << YAML::Value << YAML::DoubleQuoted << result.problem;
  out << YAML::Key << "series" << YAML::Value << YAML::BeginSeq;
  for (const BeliefSeries& series : result.series) {
    out << YAML::BeginMap;
    out << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << series.name;
    out << YAML::Key << "problem" << YAML::Value << YAML::DoubleQuoted << series.problem;
    out << YAML::Key << "steps" << YAML::Value << YAML::BeginSeq;
    for (const BeliefStep& step : series.steps) {
      out << YAML::Flow << YAML::BeginMap << YAML::Key << "touches" << YAML::Value << step.touches;
      for (const StepFigure& figure : kStepFigures) {
        out << YAML::Key << figure.name << YAML::Value << step.*figure.value;
      }
      out << YAML::EndMap;
    }
    out << YAML::EndSeq << YAML::EndMap;
  }
  out << YAML::EndSeq;
  out << YAML::Key << "shapes" << YAML::Value << YAML::BeginSeq;
  for (const TriedShape& shape : result.shapes) {
    out << YAML::Flow << YAML::BeginMap << YAML::Key << "method" << YAML::Value
        << static_cast<int>(shape.terms.method) << YAML::Key << "mirrored_below" << YAML::Value
        << shape.terms.mirrored_below << YAML::Key << "worse" << YAML::Value << shape.terms.worse
        << YAML::Key << "lost" << YAML::Value << shape.terms.lost << YAML::Key << "unseen"
        << YAML::Value << shape.unseen << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return out.c_str();
}

BeliefCase read_belief_case(const std::string& text) {
  try {
    const YAML::Node node = YAML::Load(text);
    BeliefCase result;
    result.case_name = node["case"].as<std::string>();
    result.group = node["group"].as<std::string>();
    result.data_set = node["data_set"].as<std::string>();
    result.orientation = node["orientation"].as<int>();
    result.problem = node["problem"].as<std::string>();
    for (const YAML::Node& one : node["series"]) {
      BeliefSeries series;
      series.name = one["name"].as<std::string>();
      series.problem = one["problem"].as<std::string>();
      for (const YAML::Node& at : one["steps"]) {
        BeliefStep step;
        step.touches = at["touches"].as<int>();
        for (const StepFigure& figure : kStepFigures) {
          step.*figure.value = at[figure.name].as<double>();
        }
        series.steps.push_back(step);
      }
      result.series.push_back(series);
    }
    for (const YAML::Node& one : node["shapes"]) {
      TriedShape shape;
      shape.terms = {static_cast<shape::CompletionMethod>(one["method"].as<int>()),
                     one["mirrored_below"].as<bool>(), one["worse"].as<double>(),
                     one["lost"].as<double>()};
      shape.unseen = one["unseen"].as<double>();
      result.shapes.push_back(shape);
    }
    return result;
  } catch (const YAML::Exception& error) {
    throw geometry::InputError(std::string("The text is no result of a belief: ") + error.what(),
                               "Run the case again");
  }
}

}  // namespace prehend::eval
