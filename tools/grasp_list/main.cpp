// grasp_list: what `prehend grasps` becomes; see there.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>

#include <CLI/CLI.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/known/grasp_database.h"
#include "prehend/text/command_line.h"
#include "tools/json.h"
#include "tools/table.h"

namespace {

using namespace prehend;

// How often grasps of an object were executed, and held.
struct Executions {
  int attempts = 0;
  int successes = 0;
};

Executions executions_of(const grasp::GraspDatabase& database, const grasp::StoredObject& object) {
  Executions sum;
  for (const auto& grasp : database.grasps(object.hand, object.hash)) {
    sum.attempts += grasp.attempts;
    sum.successes += grasp.successes;
  }
  return sum;
}

void list(const grasp::GraspDatabase& database, bool json) {
  tools::Json objects = tools::Json::array();
  std::vector<std::vector<std::string>> rows{
      {"OBJECT", "HAND", "GRASPS", "EXECUTED", "HELD", "HASH"}};
  for (const auto& object : database.objects()) {
    const Executions executions = executions_of(database, object);
    rows.push_back({object.name, object.hand, std::to_string(object.grasps),
                    std::to_string(executions.attempts), std::to_string(executions.successes),
                    object.hash.substr(0, 12)});
    objects.add(tools::Json::object()
                    .set("name", object.name)
                    .set("hand", object.hand)
                    .set("grasps", object.grasps)
                    .set("attempts", executions.attempts)
                    .set("successes", executions.successes)
                    .set("hash", object.hash));
  }
  if (json) {
    tools::print(tools::Json::object().set("objects", objects));
  } else {
    tools::print_table(rows);
  }
}

// The objects of which the hash begins so, or with that name.
void forget(grasp::GraspDatabase& database, const std::string& which) {
  int removed = 0;
  for (const auto& object : database.objects()) {
    const bool meant =
        object.name == which || (which.size() >= 6 && object.hash.rfind(which, 0) == 0);
    if (meant && database.remove(object.hand, object.hash)) ++removed;
  }
  if (removed == 0) {
    throw geometry::InputError("The database has no object '" + which + "'",
                               "Give a name, or at least 6 figures of a hash, as listed");
  }
  std::printf("forgot %d\n", removed);
}

}  // namespace

int main(int argc, char** argv) {
  std::string file, which;
  bool csv = false, json = false;
  CLI::App app("List, export or forget the grasps of known objects", "prehend grasps");
  app.add_option("file", file)->required();
  app.add_flag("--csv", csv);
  app.add_flag("--json", json);
  app.add_option("--forget", which);
  if (const auto code = text::parse_command_line(app, argc, argv)) return *code;
  try {
    if (!std::filesystem::exists(file)) {
      throw geometry::InputError("There is no file '" + file + "'",
                                 "Name a database that `prehend plan --database` wrote");
    }
    grasp::GraspDatabase database(file);
    if (!which.empty()) {
      forget(database, which);
    } else if (csv) {
      database.write_csv(std::cout);
      std::cout.flush();
    } else {
      list(database, json);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend grasps: %s\n", error.what());
    return 1;
  }
}
