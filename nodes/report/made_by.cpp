#include "nodes/report/made_by.h"

#include <cstdlib>

#include "prehend_revision.h"

namespace prehend::nodes {

std::vector<std::vector<std::string>> made_by() {
  std::string version = kVersion;
  if (*kRevision) version += std::string(", revision ") + kRevision;
  std::vector<std::vector<std::string>> rows{{"prehend", version}};
  const char* command = std::getenv("PREHEND_COMMAND");
  if (command && *command) rows.push_back({"command", command});
  return rows;
}

}  // namespace prehend::nodes
