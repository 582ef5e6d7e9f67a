// prehend bag check, filter, attachments, info --json and export.

#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "msgs/convert/geometry.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/graph/schema.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/mcap_writer.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;
using recording::McapReader;
using recording::McapWriter;
using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Result {
  int exit_code;
  std::string output;
};

std::uint16_t add_channel(McapWriter& writer, const std::string& topic,
                          const google::protobuf::Descriptor& type,
                          const std::map<std::string, std::string>& metadata = {}) {
  const auto schema = graph::schema_of(type);
  return writer.add_channel(topic, "protobuf",
                            writer.add_schema(schema->name, "protobuf", schema->descriptor_set),
                            metadata);
}

msgs::StereoPair picture() {  // left: red, right: blue
  msgs::StereoPair pair;
  pair.mutable_header()->set_stamp(1'700'000'000'123'456'789);
  pair.set_width(3);
  pair.set_height(2);
  pair.set_channels(3);
  std::string data;
  for (int i = 0; i < 6; ++i) data += std::string("\xff\x10\x00", 3);
  for (int i = 0; i < 6; ++i) data += std::string("\x00\x10\xff", 3);
  pair.set_data(data);
  return pair;
}

msgs::ObjectHypotheses objects() {
  geometry::PointCloud cloud;
  cloud.points = {{1, 2, 3}, {4, 5, 6.5F}};
  msgs::ObjectHypotheses message;
  message.mutable_header()->set_stamp(77);
  message.set_problem("a, \"quoted\" one");
  *message.add_objects()->mutable_cloud() = convert::to_message(cloud);
  *message.add_objects()->mutable_cloud() = convert::to_message(cloud);
  message.mutable_camera()->set_width(2);
  message.mutable_camera()->set_height(1);
  message.set_depth(std::string("\x10\x27\x00\x00", 4));  // 1 m, unknown
  return message;
}

class Bag : public ::testing::Test {
 protected:
  Bag() {
    McapWriter writer(file_);
    writer.add_attachment({5, 5, "../../calibration.yaml", "text/yaml", "fx: 500\n"});
    writer.add_metadata({"prehend.losses", {{"/touch", "3 lost"}}});
    const auto camera =
        add_channel(writer, "/camera/stereo", *msgs::StereoPair::descriptor(), {{"latched", "1"}});
    const auto found = add_channel(writer, "/objects", *msgs::ObjectHypotheses::descriptor());
    const auto touch = add_channel(writer, "/touch", *msgs::TactileFrame::descriptor());
    writer.write(camera, 1, 1'000'000'000, 999'999'999, picture().SerializeAsString());
    writer.write(found, 1, 1'500'000'000, 1'400'000'000, objects().SerializeAsString());
    for (std::uint32_t i = 1; i <= 4; ++i) {
      msgs::TactileFrame frame;
      frame.mutable_header()->set_stamp(1000 + i);
      frame.mutable_header()->set_frame_id("left_pad");
      frame.set_sum(0.1 * i);
      for (std::uint32_t texel = 0; texel < i; ++texel) frame.add_intensity(texel);
      writer.write(touch, i, 2'000'000'000 + i, 2'000'000'000, frame.SerializeAsString());
    }
    writer.close();
  }

  Result run(std::vector<std::string> words) {
    words.insert(words.begin(), "bag");
    ChildProgram program("prehend", words, scratch_.path("out.txt"));
    const int code = program.wait(seconds(30)).value_or(-1);
    return {code, program.output()};
  }

  std::vector<std::string> lines_of(const std::string& path) {
    std::ifstream stream(path);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }

  ScratchDirectory scratch_;
  const std::string file_ = scratch_.path("a.mcap");
};

TEST_F(Bag, CheckFindsDamageAndSaysSoByItsExitCode) {
  const Result sound = run({"check", file_});
  EXPECT_EQ(sound.exit_code, 0) << sound.output;
  EXPECT_THAT(sound.output, HasSubstr("6 messages, 1 chunks, 1 attachments: all is well"));
  std::ifstream in(file_, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  bytes[bytes.find("fx: 500")] = 'F';
  scratch_.write("b.mcap", bytes);
  const Result damaged = run({"check", scratch_.path("b.mcap")});
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_THAT(damaged.output, AllOf(HasSubstr("problem: the attachment ../../calibration.yaml"),
                                    HasSubstr("NOT SOUND")));
  EXPECT_EQ(run({"check", scratch_.write("c.mcap", "no recording")}).exit_code, 1);
  EXPECT_EQ(run({"check", scratch_.path("none.mcap")}).exit_code, 1);
}

TEST_F(Bag, InfoHasRatesLossesAndJson) {
  const Result text = run({"info", file_});
  EXPECT_THAT(text.output, AllOf(HasSubstr("4.0 Hz"), HasSubstr("prehend.losses /touch = 3 lost"),
                                 HasSubstr("calibration.yaml (text/yaml, 8 bytes)")));
  const Result json = run({"info", file_, "--json"});
  google::protobuf::Struct info;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(json.output, &info).ok()) << json.output;
  const auto& fields = info.fields();
  EXPECT_EQ(fields.at("messages").number_value(), 6);
  EXPECT_EQ(fields.at("start_time").string_value(), "1000000000");
  EXPECT_TRUE(fields.at("complete").bool_value());
  ASSERT_EQ(fields.at("topics").list_value().values_size(), 3);
  const auto& topic = fields.at("topics").list_value().values(0).struct_value().fields();
  EXPECT_EQ(topic.at("type").string_value(), "prehend.msgs.StereoPair");
  EXPECT_EQ(topic.at("latched").number_value(), 1);
}

TEST_F(Bag, FilterCutsTopicsAndTimesAndKeepsWhatWasLatched) {
  const std::string to = scratch_.path("b.mcap");
  const Result part = run({"filter", file_, to, "--without", "/obj*", "--start", "1.000000003s",
                           "--end", "2000ms", "--compression", "zstd"});
  EXPECT_EQ(part.exit_code, 0) << part.output;
  EXPECT_EQ(run({"check", to}).exit_code, 0);
  McapReader reader(to);
  EXPECT_EQ(reader.attachments().size(), 1u);
  ASSERT_EQ(reader.channels().size(), 2u);
  std::vector<std::pair<std::string, std::uint64_t>> found;
  auto cursor = reader.messages();
  while (const auto message = cursor.next()) {
    found.emplace_back(reader.channels().at(message->channel_id).topic, message->log_time);
  }
  EXPECT_EQ(found, (decltype(found){{"/camera/stereo", 2'000'000'003},
                                    {"/touch", 2'000'000'003},
                                    {"/touch", 2'000'000'004}}));
  EXPECT_EQ(run({"filter", file_, to}).exit_code, 1) << "it exists";
  EXPECT_THAT(run({"filter", file_, scratch_.path("c.mcap"), "--topics", "/tuoch"}).output,
              HasSubstr("\"/touch\""));
  EXPECT_FALSE(fs::exists(scratch_.path("c.mcap")));
}

TEST_F(Bag, AttachmentsComeOutInsideTheFolderOnly) {
  EXPECT_THAT(run({"attachments", file_}).output, HasSubstr("calibration.yaml  text/yaml  8"));
  EXPECT_EQ(run({"attachments", file_, "-o", scratch_.path("files")}).exit_code, 0);
  EXPECT_EQ(text_of_file(scratch_.path("files/calibration.yaml")), "fx: 500\n");
  EXPECT_EQ(run({"attachments", file_, "-o", scratch_.path("files")}).exit_code, 1) << "it exists";
  EXPECT_EQ(run({"attachments", file_, "-n", "no"}).exit_code, 1);
}

TEST_F(Bag, ExportWritesTablesPicturesAndClouds) {
  const std::string folder = scratch_.path("out");
  const Result result = run({"export", file_, folder});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const auto touch = lines_of(folder + "/touch.csv");
  ASSERT_EQ(touch.size(), 5u);
  EXPECT_EQ(touch[0],
            "log_time,publish_time,sequence,header.stamp,header.frame_id,rows,columns,texel_width,"
            "texel_height,full_scale,intensity[0],intensity[1],intensity[2],intensity[3],sum,"
            "newton_per_count");
  EXPECT_EQ(touch[2], "2000000002,2000000000,2,1002,left_pad,0,0,0,0,0,0,1,,,0.2,0");
  const auto found = lines_of(folder + "/objects.csv");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_THAT(found[0], HasSubstr("objects[1].cloud.data.size"));
  EXPECT_THAT(found[1], HasSubstr("\"a, \"\"quoted\"\" one\""));

  const std::string stem = folder + "/camera/stereo/1700000000123456789";
  const cv::Mat left = cv::imread(stem + "_left.png", cv::IMREAD_COLOR);
  ASSERT_EQ(left.size(), cv::Size(3, 2));
  EXPECT_EQ(left.at<cv::Vec3b>(1, 2), cv::Vec3b(0, 0x10, 0xff)) << "blue, green, red";
  EXPECT_EQ(cv::imread(stem + "_right.png", cv::IMREAD_COLOR).at<cv::Vec3b>(0, 0),
            cv::Vec3b(0xff, 0x10, 0));
  const cv::Mat depth = cv::imread(folder + "/objects/77_depth.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_16UC1);
  EXPECT_EQ(depth.at<std::uint16_t>(0, 0), 10'000);
  for (const char* name :
       {"/objects/77_objects[0].cloud.pcd", "/objects/77_objects[1].cloud.pcd"}) {
    const auto cloud = geometry::read_cloud_file(folder + name);
    ASSERT_EQ(cloud.cloud.size(), 2u) << name;
    EXPECT_EQ(cloud.cloud.points[1], Eigen::Vector3f(4, 5, 6.5F));
  }
  EXPECT_EQ(run({"export", file_, folder}).exit_code, 1) << "it is not empty";
}

TEST_F(Bag, HelpHasExamples) {
  for (const char* command : {"info", "check", "filter", "export", "attachments", "recover"}) {
    const Result help = run({command, "--help"});
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_THAT(help.output, HasSubstr("Example")) << command;
  }
}

// What a recording from elsewhere may hold.
TEST_F(Bag, ExportSurvivesHostileContent) {
  const std::string hostile = scratch_.path("b.mcap");
  {
    McapWriter writer(hostile);
    const auto stereo = add_channel(writer, "/stereo", *msgs::StereoPair::descriptor());
    const auto found = add_channel(writer, "/objects", *msgs::ObjectHypotheses::descriptor());
    auto pair = picture();
    pair.set_width(4'000'000'000u);
    writer.write(stereo, 1, 1, 1, pair.SerializeAsString());
    pair = picture();
    pair.set_channels(7);
    writer.write(stereo, 2, 2, 2, pair.SerializeAsString());
    writer.write(stereo, 3, 3, 3, "\xff\xff\xff");
    writer.write(stereo, 4, 4, 4, picture().SerializeAsString());
    auto message = objects();
    message.mutable_objects(0)->mutable_cloud()->set_count(4'000'000'000u);
    writer.write(found, 1, 5, 5, message.SerializeAsString());
    writer.close();
  }
  const Result result = run({"export", hostile, scratch_.path("out")});
  EXPECT_EQ(result.exit_code, 1) << "not all could be written";
  EXPECT_THAT(result.output, AllOf(HasSubstr("4000000000 x 2 pixels"), HasSubstr("7 channels"),
                                   HasSubstr("left out"), HasSubstr("objects[0].cloud")));
  EXPECT_TRUE(fs::exists(scratch_.path("out/stereo/1700000000123456789_2_left.png")) ||
              fs::exists(scratch_.path("out/stereo/1700000000123456789_4_left.png")));
  {
    McapWriter writer(scratch_.path("c.mcap"));
    const auto outside = add_channel(writer, "/../../x", *msgs::TactileFrame::descriptor());
    writer.write(outside, 1, 1, 1, msgs::TactileFrame().SerializeAsString());
    writer.close();
  }
  EXPECT_THAT(run({"export", scratch_.path("c.mcap"), scratch_.path("out2")}).output,
              HasSubstr("cannot be a file name"));
  EXPECT_EQ(run({"export", scratch_.path("none.mcap"), scratch_.path("out3")}).exit_code, 1);
}

}  // namespace
}  // namespace prehend::testing
