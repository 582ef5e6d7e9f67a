#include "prehend/robot/urdf_document.h"

#include <algorithm>
#include <exception>
#include <fstream>
#include <sstream>

#include <console_bridge/console.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/xml_size.h"

namespace prehend::robot {
namespace {

using geometry::InputError;

constexpr const char* kMend = "See http://wiki.ros.org/urdf/XML";

/// What the parser complains of, for the error's text; it writes to the terminal otherwise.
class Complaints : public console_bridge::OutputHandler {
 public:
  Complaints() { console_bridge::useOutputHandler(this); }
  ~Complaints() override { console_bridge::restorePreviousOutputHandler(); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_WARN) return;
    text_ += (text_.empty() ? "" : "; ") + text;
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR)
      errors_ += (errors_.empty() ? "" : "; ") + text;
  }
  const std::string& text() const { return text_; }
  const std::string& errors() const { return errors_; }

 private:
  std::string text_, errors_;
};

std::string without_comments(const std::string& text) {
  std::string rest;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = std::min(text.find("<!--", at), text.size());
    rest.append(text, at, begin - at);
    const std::size_t end = begin < text.size() ? text.find("-->", begin) : std::string::npos;
    at = end == std::string::npos ? text.size() : end + 3;
  }
  return rest;
}

/// The parser calls itself from each link to the next, and takes time as the square of all.
void refuse_too_much(const std::string& text, const std::string& name) {
  constexpr std::size_t kMostBytes = 64 << 20, kMostLinks = 10000;
  if (text.size() > kMostBytes) {
    throw InputError("'" + name + "' is larger than 64 MiB: no robot's file", "Check the path");
  }
  text::refuse_xml_bomb(text, name);
  std::size_t links = 0;
  for (std::size_t at = text.find("<link"); at != std::string::npos;
       at = text.find("<link", at + 5))
    ++links;
  if (links > kMostLinks) {
    throw InputError("'" + name + "' has more than 10000 links", "No robot has so many: split it");
  }
}

/// The parser passes over xacro's elements, so that of a file of macros next to nothing is left.
/// What xacro has made of one may still name its namespace, and have macros in comments.
void refuse_macros(const std::string& all, const std::string& name) {
  const std::string text = without_comments(all);
  for (const char* sign : {"<xacro:", "${", "$("}) {
    if (text.find(sign) == std::string::npos) continue;
    throw InputError("'" + name + "' has xacro macros, which are not read",
                     "Expand them: xacro " + name + " > robot.urdf");
  }
}

}  // namespace

std::shared_ptr<urdf::ModelInterface> parse_urdf_document(const std::string& text,
                                                          const std::string& name) {
  refuse_too_much(text, name);
  refuse_macros(text, name);
  std::shared_ptr<urdf::ModelInterface> document;
  const Complaints complaints;
  try {
    document = urdf::parseURDF(text);
  } catch (const std::exception& error) {
    throw InputError("'" + name + "' is no URDF: " + error.what(), kMend);
  }
  if (!document || !document->getRoot()) {
    throw InputError("'" + name + "' is no URDF: " + complaints.text(), kMend);
  }
  // It leaves out the shape or link that it cannot read, and goes on.
  if (!complaints.errors().empty()) {
    throw InputError("'" + name + "': " + complaints.errors(), kMend);
  }
  return document;
}

std::shared_ptr<urdf::ModelInterface> read_urdf_document(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  if (!stream || !(text << stream.rdbuf())) {
    throw InputError("'" + file.string() + "' cannot be read", "Check the path");
  }
  return parse_urdf_document(text.str(), file.string());
}

geometry::RigidTransform to_transform(const urdf::Pose& pose) {
  double x, y, z, w;
  pose.rotation.getQuaternion(x, y, z, w);
  return geometry::make_transform(Eigen::Quaterniond(w, x, y, z),
                                  {pose.position.x, pose.position.y, pose.position.z});
}

}  // namespace prehend::robot
