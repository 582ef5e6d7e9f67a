// prehend's own text of a robot, without a loss: docs/models.md names every key.

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/json_record.h"
#include "prehend/robot/formats/robot_record.h"

namespace prehend::robot::formats {
namespace {

constexpr int kVersion = 1;

class OwnJson : public RobotFormat {
 public:
  std::string name() const override { return "json"; }
  bool recognises(const XmlElement&) const override { return false; }
  bool recognises_text(std::string_view head) const override {
    const std::size_t first = head.find_first_not_of(" \t\r\n");
    return first != std::string_view::npos && head[first] == '{';
  }
  std::string ending() const override { return ".json"; }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    const std::string name = file.string();
    const JsonValue value = parse_json(whole_file(file), name);
    JsonReader reader(value, "", name, loss);
    int version = 0;
    reader.field("prehend_robot", version);
    if (version != kVersion) {
      reader.fail("prehend_robot", std::to_string(version) + " is no version that is known",
                  "This reads version " + std::to_string(kVersion));
    }
    RobotDescription robot;
    fields(reader, robot);
    reader.finish();
    tree_order(robot);
    return robot;
  }
  bool can_write() const override { return true; }
  std::string write(const RobotDescription& robot, LossReport& loss) const override {
    JsonWriter writer("", loss);
    writer.field("prehend_robot", kVersion);
    fields(writer, robot);
    return json_text(writer.object(), loss);
  }
};

}  // namespace

std::unique_ptr<RobotFormat> json_format() { return std::make_unique<OwnJson>(); }

}  // namespace prehend::robot::formats
