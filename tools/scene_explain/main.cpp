// scene_explain SCENE [--json]: what `prehend explain` becomes; see there.

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "prehend/simulation/explain.h"
#include "tools/json.h"
#include "tools/table.h"

namespace {

using namespace prehend;
using simulation::Explanation;
using simulation::LeftOutPart;
using simulation::ModelledPart;

void print_json(const std::string& scene, const Explanation& explanation) {
  tools::Json modelled = tools::Json::array(), left_out = tools::Json::array();
  for (const ModelledPart& part : explanation.modelled) {
    modelled.add(tools::Json::object().set("what", part.what).set("how", part.how));
  }
  for (const LeftOutPart& part : explanation.left_out) {
    left_out.add(tools::Json::object()
                     .set("what", part.what)
                     .set("rule", part.rule)
                     .set("error", part.error)
                     .set("unit", part.unit)
                     .set("error_text", part.error_text)
                     .set("why", part.why));
  }
  tools::print(tools::Json::object()
                   .set("scene", scene)
                   .set("modelled", modelled)
                   .set("left_out", left_out)
                   .set("rules_off", explanation.rules_off));
}

void print_text(const std::string& scene, const Explanation& explanation) {
  std::printf("%s\n\n", scene.c_str());
  std::vector<std::vector<std::string>> rows{{"MODELLED", "HOW"}};
  for (const ModelledPart& part : explanation.modelled) rows.push_back({part.what, part.how});
  tools::print_table(rows);
  std::printf("\n");
  rows = {{"LEFT OUT", "RULE", "ERROR", "WHY"}};
  for (const LeftOutPart& part : explanation.left_out) {
    rows.push_back({part.what, part.rule.empty() ? "-" : part.rule, part.error_text, part.why});
  }
  tools::print_table(rows);
  if (explanation.rules_off.empty()) return;
  std::printf("\nRules that are off: %s\n", tools::joined(explanation.rules_off).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const bool json = words.size() == 2 && words[1] == "--json";
  if (words.empty() || (words.size() > 1 && !json)) {
    std::fprintf(stderr, "usage: prehend explain SCENE [--json]\n");
    return 2;
  }
  try {
    const Explanation explanation = simulation::explain(simulation::read_scene(words[0]));
    if (json) {
      print_json(words[0], explanation);
    } else {
      print_text(words[0], explanation);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend explain: %s\n", error.what());
    return 1;
  }
  return 0;
}
