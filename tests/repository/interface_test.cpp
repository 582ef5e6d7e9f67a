// Messages that recordings and other people's nodes hold on to: msgs/interface.txt has every field
// as it was when somebody recorded it. PREHEND_RECORD_INTERFACE=1 in the environment records it
// anew.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>

#include "msgs/actions.pb.h"
#include "msgs/belief.pb.h"
#include "msgs/camera.pb.h"
#include "msgs/geometry.pb.h"
#include "msgs/graph.pb.h"
#include "msgs/grasp.pb.h"
#include "msgs/hand.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/percepts.pb.h"
#include "msgs/safety.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/touch.pb.h"
#include "msgs/truth.pb.h"

namespace prehend::testing {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;

const char* const kFile = "msgs/interface.txt";

std::string type_of(const FieldDescriptor& field) {
  if (field.message_type()) return field.message_type()->full_name();
  if (field.enum_type()) return field.enum_type()->full_name();
  return field.type_name();
}

void add(const EnumDescriptor& type, std::set<std::string>* lines) {
  for (int i = 0; i < type.value_count(); ++i) {
    lines->insert(fmt::format("{} {} = {}", type.full_name(), type.value(i)->name(),
                              type.value(i)->number()));
  }
}

void add(const Descriptor& type, std::set<std::string>* lines) {
  lines->insert(type.full_name());
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    const char* label = field.is_repeated()                             ? "repeated "
                        : field.has_presence() && !field.message_type() ? "optional "
                                                                        : "";
    lines->insert(fmt::format("{} {} = {} {}{}", type.full_name(), field.name(), field.number(),
                              label, type_of(field)));
  }
  for (int i = 0; i < type.nested_type_count(); ++i) add(*type.nested_type(i), lines);
  for (int i = 0; i < type.enum_type_count(); ++i) add(*type.enum_type(i), lines);
}

std::set<std::string> interface_now() {
  const std::set<const FileDescriptor*> files{
      msgs::MoveGripperGoal::descriptor()->file(), msgs::Belief::descriptor()->file(),
      msgs::Image::descriptor()->file(),           msgs::Header::descriptor()->file(),
      msgs::graph::LogLine::descriptor()->file(),  msgs::GraspPlan::descriptor()->file(),
      msgs::HandStatus::descriptor()->file(),      msgs::JointState::descriptor()->file(),
      msgs::ObjectModel::descriptor()->file(),     msgs::ActPercepts::descriptor()->file(),
      msgs::EmergencyStop::descriptor()->file(),   msgs::StereoPair::descriptor()->file(),
      msgs::Touch::descriptor()->file(),           msgs::TruthShapes::descriptor()->file()};
  std::size_t written = 0;
  for (const auto& entry : std::filesystem::directory_iterator("msgs")) {
    written += entry.path().extension() == ".proto";
  }
  EXPECT_EQ(files.size(), written) << "a file of msgs/ is not in this list";
  std::set<std::string> lines;
  for (const FileDescriptor* file : files) {
    for (int i = 0; i < file->message_type_count(); ++i) add(*file->message_type(i), &lines);
    for (int i = 0; i < file->enum_type_count(); ++i) add(*file->enum_type(i), &lines);
  }
  return lines;
}

TEST(Interface, OfMessagesIsAsItIsRecorded) {
  const std::set<std::string> now = interface_now();
  if (std::getenv("PREHEND_RECORD_INTERFACE")) {
    std::ofstream out(kFile);
    for (const std::string& line : now) out << line << '\n';
    ASSERT_TRUE(out.flush());
  }
  std::set<std::string> recorded;
  std::ifstream in(kFile);
  for (std::string line; std::getline(in, line);) recorded.insert(line);
  std::vector<std::string> gone, fresh;
  std::set_difference(recorded.begin(), recorded.end(), now.begin(), now.end(),
                      std::back_inserter(gone));
  std::set_difference(now.begin(), now.end(), recorded.begin(), recorded.end(),
                      std::back_inserter(fresh));
  EXPECT_THAT(gone, ::testing::IsEmpty())
      << "Recordings and nodes of others have these. Keep them; or say in CHANGELOG.md what they "
         "do "
         "instead, raise the version in CMakeLists.txt, and record the interface anew: "
         "PREHEND_RECORD_INTERFACE=1 build/bin/test_repository";
  EXPECT_THAT(fresh, ::testing::IsEmpty())
      << "These are new: record them, PREHEND_RECORD_INTERFACE=1 build/bin/test_repository";
}

}  // namespace
}  // namespace prehend::testing
