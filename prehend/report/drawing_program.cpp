#include "prehend/report/drawing_program.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <unistd.h>

namespace prehend::report {
namespace {

// A private folder that goes with its owner.
struct TemporaryFolder {
  std::filesystem::path path;
  TemporaryFolder() {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-chart-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) {
      throw std::runtime_error("cannot make a temporary folder for a chart");
    }
    path = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;  // a left-over in /tmp is no reason to fail
    std::filesystem::remove_all(path, ignored);
  }
};

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

std::string drawn_by(
    const DrawingProgram& program, const std::string& title,
    const std::function<void(const std::filesystem::path& folder, std::ostream& script)>& write) {
  const TemporaryFolder folder;
  {
    std::ofstream script(folder.path / "script");
    write(folder.path, script);
  }
  const std::string command =
      "cd '" + folder.path.string() + "' && " + program.command + " >errors 2>&1 </dev/null";
  const int status = std::system(command.c_str());
  const std::string svg = text_of(folder.path / "chart.svg");
  if (status != 0 || svg.find("</svg>") == std::string::npos) {
    throw std::runtime_error(program.name + " could not draw '" + title +
                             "': " + text_of(folder.path / "errors") + "(is the package " +
                             program.package + " installed?)");
  }
  return svg.substr(svg.find("<svg"));
}

}  // namespace prehend::report
