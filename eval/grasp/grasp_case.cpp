#include "eval/grasp/grasp_case.h"

#include <algorithm>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

// The figures of a trial by their names in the file.
struct Figure {
  const char* name;
  double GraspTrial::*value;
};
constexpr Figure kFigures[] = {{"plan_seconds", &GraspTrial::plan_seconds},
                               {"grasp_seconds", &GraspTrial::grasp_seconds},
                               {"slip", &GraspTrial::slip},
                               {"contact_error", &GraspTrial::contact_error},
                               {"area_error", &GraspTrial::area_error},
                               {"opening_error", &GraspTrial::opening_error},
                               {"robustness", &GraspTrial::robustness},
                               {"first_robustness", &GraspTrial::first_robustness},
                               {"best_robustness", &GraspTrial::best_robustness},
                               {"guessed_contact", &GraspTrial::guessed_contact}};
struct Count {
  const char* name;
  int GraspTrial::*value;
};
constexpr Count kCounts[] = {
    {"candidates", &GraspTrial::candidates}, {"grasps", &GraspTrial::grasps},
    {"attempts", &GraspTrial::attempts},     {"touches", &GraspTrial::touches},
    {"plans", &GraspTrial::plans},           {"recalled", &GraspTrial::recalled}};

template <class Value>
void put(YAML::Emitter& out, const char* key, const Value& value) {
  out << YAML::Key << key << YAML::Value << value;
}

void put_text(YAML::Emitter& out, const char* key, const std::string& text) {
  out << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << text;
}

void put_surprises(YAML::Emitter& out, const std::vector<control::Surprise>& surprises) {
  out << YAML::Key << "surprises" << YAML::Value << YAML::BeginSeq;
  for (const control::Surprise& surprise : surprises) {
    out << YAML::Flow << YAML::BeginMap;
    put(out, "kind", static_cast<int>(surprise.kind));
    put(out, "predicted", surprise.predicted);
    put(out, "felt", surprise.felt);
    put(out, "surprising", surprise.surprising);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

std::vector<control::Surprise> surprises_of(const YAML::Node& list) {
  std::vector<control::Surprise> surprises;
  for (const YAML::Node& one : list) {
    const int kind = one["kind"].as<int>();
    if (kind < 0 || kind > static_cast<int>(control::SurpriseKind::kSlip)) {
      throw YAML::RepresentationException(one["kind"].Mark(), "no kind of surprise");
    }
    control::Surprise surprise;
    surprise.kind = static_cast<control::SurpriseKind>(kind);
    surprise.predicted = one["predicted"].as<double>();
    surprise.felt = one["felt"].as<double>();
    surprise.surprising = one["surprising"].as<bool>();
    surprises.push_back(surprise);
  }
  return surprises;
}

}  // namespace

const char* to_string(PlannedOn planned_on) {
  switch (planned_on) {
    case PlannedOn::kPredicted:
      return "predicted";
    case PlannedOn::kTruth:
      return "truth";
    case PlannedOn::kDelaunay:
      return "delaunay";
  }
  return "";
}

const GraspTrial* GraspCase::trial(const std::string& setting) const {
  const auto found = std::find_if(trials.begin(), trials.end(),
                                  [&](const GraspTrial& t) { return t.setting == setting; });
  return found == trials.end() ? nullptr : &*found;
}

std::vector<GraspTrial> GraspCase::executed() const {
  std::vector<GraspTrial> result = trials;
  std::erase_if(result, [](const GraspTrial& t) { return t.is_planned_only; });
  return result;
}

bool GraspCase::fits() const {
  const GraspTrial* truth = trial(to_string(PlannedOn::kTruth));
  return truth != nullptr && truth->best_robustness >= 0.5;
}

std::string to_text(const GraspCase& result) {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::BeginMap;
  put_text(out, "case", result.case_name);
  put_text(out, "group", result.group);
  put_text(out, "data_set", result.data_set);
  put_text(out, "platform", result.platform);
  put(out, "orientation", result.orientation);
  put(out, "others", result.others);
  put_text(out, "problem", result.problem);
  put(out, "predict_seconds", result.predict_seconds);
  out << YAML::Key << "trials" << YAML::Value << YAML::BeginSeq;
  for (const GraspTrial& trial : result.trials) {
    out << YAML::BeginMap;
    put_text(out, "setting", trial.setting);
    put_text(out, "problem", trial.problem);
    put_text(out, "outcome", trial.outcome);
    put_text(out, "stage", trial.stage);
    put(out, "planned_only", trial.is_planned_only);
    put(out, "lifted", trial.lifted);
    for (const Count& count : kCounts) put(out, count.name, trial.*count.value);
    for (const Figure& figure : kFigures) put(out, figure.name, trial.*figure.value);
    put_surprises(out, trial.surprises);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return out.c_str();
}

GraspCase read_grasp_case(const std::string& text) {
  try {
    const YAML::Node node = YAML::Load(text);
    GraspCase result;
    result.case_name = node["case"].as<std::string>();
    result.group = node["group"].as<std::string>();
    result.data_set = node["data_set"].as<std::string>();
    result.platform = node["platform"].as<std::string>();
    result.orientation = node["orientation"].as<int>();
    result.others = node["others"].as<int>();
    result.problem = node["problem"].as<std::string>();
    result.predict_seconds = node["predict_seconds"].as<double>();
    for (const YAML::Node& one : node["trials"]) {
      GraspTrial trial;
      trial.setting = one["setting"].as<std::string>();
      trial.problem = one["problem"].as<std::string>();
      trial.outcome = one["outcome"].as<std::string>();
      trial.stage = one["stage"].as<std::string>();
      trial.is_planned_only = one["planned_only"].as<bool>();
      trial.lifted = one["lifted"].as<bool>();
      trial.surprises = surprises_of(one["surprises"]);
      for (const Count& count : kCounts) trial.*count.value = one[count.name].as<int>();
      for (const Figure& figure : kFigures) trial.*figure.value = one[figure.name].as<double>();
      result.trials.push_back(trial);
    }
    return result;
  } catch (const YAML::Exception& error) {
    throw geometry::InputError(std::string("The text is no result of a grasp: ") + error.what(),
                               "Run the case again");
  }
}

}  // namespace prehend::eval
