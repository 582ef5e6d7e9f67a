#include "eval/case_result.h"

#include <cstdint>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

using geometry::InputError;

// The figures of a MethodResult by their names in the file.
struct ResultFigure {
  const char* name;
  double MethodResult::*value;
};
constexpr ResultFigure kFigures[] = {{"mean", &MethodResult::mean},
                                     {"variance", &MethodResult::variance},
                                     {"percentile_95", &MethodResult::percentile_95},
                                     {"max", &MethodResult::max},
                                     {"back_mean", &MethodResult::back_mean},
                                     {"back_max", &MethodResult::back_max},
                                     {"centroid_error", &MethodResult::centroid_error},
                                     {"normal_error", &MethodResult::normal_error},
                                     {"jaccard", &MethodResult::jaccard},
                                     {"moved", &MethodResult::moved},
                                     {"turned", &MethodResult::turned},
                                     {"vote", &MethodResult::vote},
                                     {"confidence", &MethodResult::confidence},
                                     {"seconds", &MethodResult::seconds}};

struct EvidenceFigure {
  const char* name;
  double shape::Evidence::*value;
};
constexpr EvidenceFigure kEvidence[] = {{"contradiction", &shape::Evidence::contradiction},
                                        {"contradicted", &shape::Evidence::contradicted},
                                        {"support", &shape::Evidence::support},
                                        {"coincident", &shape::Evidence::coincident},
                                        {"unseen", &shape::Evidence::unseen},
                                        {"margin", &shape::Evidence::margin},
                                        {"concavity", &shape::Evidence::concavity},
                                        {"open_top", &shape::Evidence::open_top},
                                        {"occluded", &shape::Evidence::occluded},
                                        {"disagreement", &shape::Evidence::disagreement},
                                        {"guessed_depth", &shape::Evidence::guessed_depth}};

void write_evidence(YAML::Emitter& out, const shape::Evidence& evidence) {
  out << YAML::Key << "evidence" << YAML::Value << YAML::BeginMap << YAML::Key << "method"
      << YAML::Value << static_cast<int>(evidence.method);
  for (const EvidenceFigure& figure : kEvidence) {
    out << YAML::Key << figure.name << YAML::Value << evidence.*figure.value;
  }
  out << YAML::Key << "cut_by_image" << YAML::Value << evidence.cut_by_image << YAML::Key
      << "on_another" << YAML::Value << evidence.on_another << YAML::Key << "may_be_several"
      << YAML::Value << evidence.may_be_several << YAML::EndMap;
}

shape::Evidence read_evidence(const YAML::Node& node) {
  shape::Evidence evidence;
  evidence.method = static_cast<shape::CompletionMethod>(node["method"].as<int>());
  for (const EvidenceFigure& figure : kEvidence) {
    evidence.*figure.value = node[figure.name].as<double>();
  }
  evidence.cut_by_image = node["cut_by_image"].as<bool>();
  evidence.on_another = node["on_another"].as<bool>();
  evidence.may_be_several = node["may_be_several"].as<bool>();
  return evidence;
}

}  // namespace

std::string to_text(const CaseResult& result) {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::BeginMap << YAML::Key << "case" << YAML::Value << result.case_name  //
      << YAML::Key << "group" << YAML::Value << result.group                       //
      << YAML::Key << "data_set" << YAML::Value << result.data_set                 //
      << YAML::Key << "orientation" << YAML::Value << result.orientation           //
      << YAML::Key << "symmetric" << YAML::Value << result.symmetric               //
      << YAML::Key << "problem" << YAML::Value << YAML::DoubleQuoted << result.problem << YAML::Key
      << "points" << YAML::Value << result.points  //
      << YAML::Key << "mask_iou" << YAML::Value << result.mask_iou << YAML::Key << "methods"
      << YAML::Value << YAML::BeginSeq;
  for (const MethodResult& method : result.methods) {
    out << YAML::BeginMap << YAML::Key << "method" << YAML::Value << method.method  //
        << YAML::Key << "problem" << YAML::Value << YAML::DoubleQuoted << method.problem;
    for (const ResultFigure& figure : kFigures) {
      out << YAML::Key << figure.name << YAML::Value << method.*figure.value;
    }
    out << YAML::Key << "watertight" << YAML::Value << method.watertight;
    if (method.evidence) write_evidence(out, *method.evidence);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;

  return out.c_str();
}

CaseResult read_case_result(const std::string& text) {
  try {
    const YAML::Node root = YAML::Load(text);
    CaseResult result;
    result.case_name = root["case"].as<std::string>();
    result.group = root["group"].as<std::string>();
    result.data_set = root["data_set"].as<std::string>();
    result.orientation = root["orientation"].as<int>();
    result.symmetric = root["symmetric"].as<bool>();
    result.problem = root["problem"].as<std::string>();
    result.points = root["points"].as<int>();
    result.mask_iou = root["mask_iou"].as<double>();
    for (const YAML::Node& node : root["methods"]) {
      MethodResult method;
      method.method = node["method"].as<std::string>();
      method.problem = node["problem"].as<std::string>();
      for (const ResultFigure& figure : kFigures) {
        method.*figure.value = node[figure.name].as<double>();
      }
      method.watertight = node["watertight"].as<bool>();
      if (node["evidence"]) method.evidence = read_evidence(node["evidence"]);
      result.methods.push_back(method);
    }
    return result;
  } catch (const YAML::Exception& error) {
    throw InputError(std::string("The text is no result of a case: ") + error.what(),
                     "Run the case again");
  }
}

}  // namespace prehend::eval
