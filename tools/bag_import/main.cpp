// Recordings of ROS as recordings of prehend: what `prehend bag import` starts.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <google/protobuf/message.h>
#include <CLI/CLI.hpp>

#include "msgs/ros/camera_pairing.h"
#include "msgs/ros/from_ros.h"
#include "prehend/geometry/errors.h"
#include "prehend/recording/latched_messages.h"
#include "prehend/recording/mcap_writer.h"
#include "prehend/recording/protobuf_schema.h"
#include "prehend/recording/recording_file.h"
#include "prehend/recording/ros_recording.h"
#include "prehend/recording/topic_filter.h"
#include "prehend/text/nearest_match.h"
#include "tools/bag_import/choices.h"

namespace {

namespace fs = std::filesystem;
namespace recording = prehend::recording;
using prehend::tools::BagImportChoices;
using namespace prehend;

/// The new recording; it has its name only once it is whole.
class Output {
 public:
  Output(const std::string& path, const std::string& compression) : path_(path) {
    if (fs::exists(path)) throw std::runtime_error(path + " exists; give a new file");
    recording::make_way(path);
    recording::McapWriterOptions options;
    options.compression = recording::compression_named(compression);
    writer_ = std::make_unique<recording::McapWriter>(recording::partial_path(path), options);
  }
  ~Output() {
    if (is_done_) return;
    std::error_code ignored;
    writer_.reset();
    fs::remove(recording::partial_path(path_), ignored);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  void write(const std::string& topic, std::uint64_t time,
             const google::protobuf::Message& message) {
    const auto* type = message.GetDescriptor();
    const auto [found, is_new] = channels_.try_emplace({topic, type->full_name()});
    Channel& channel = found->second;
    if (is_new) {
      const std::uint16_t schema =
          writer_->add_schema(type->full_name(), "protobuf", recording::file_descriptor_set(*type));
      std::map<std::string, std::string> metadata;
      if (type == msgs::CameraInfo::descriptor()) metadata[recording::kLatchedKey] = "1";
      channel.id = writer_->add_channel(topic, "protobuf", schema, metadata);
    }
    writer_->write(channel.id, ++channel.count, time, time, message.SerializeAsString());
  }
  void finish(const std::string& from) {
    writer_->add_metadata({"prehend.import", {{"from", from}}});
    writer_->close();
    recording::give_name(path_);
    is_done_ = true;
    for (const auto& [name, channel] : channels_) {
      fmt::print("{}: {} messages of {}\n", name.first, channel.count, name.second);
    }
  }

 private:
  struct Channel {
    std::uint16_t id = 0;
    std::uint32_t count = 0;
  };
  const std::string path_;
  std::unique_ptr<recording::McapWriter> writer_;
  std::map<std::pair<std::string, std::string>, Channel> channels_;  // by topic and type
  bool is_done_ = false;
};

class Import {
 public:
  explicit Import(const BagImportChoices& choices)
      : choices_(choices),
        filter_{choices.topics, {}},
        source_(choices.file),
        output_(choices.output, choices.compression) {
    if (!choices.stereo.empty()) {
      view_ = ros::pair_stereo(choices.stereo[0], choices.stereo[1]);
    } else if (!choices.depth.empty()) {
      view_ = ros::pair_depth(choices.depth, choices.color);
    }
  }

  int run() {
    while (const auto message = source_.next()) {
      topics_.insert(message->topic);
      const bool is_viewed = view_ && view_->needs(message->topic);
      // Without a choice of topics those of the view alone are taken: images twice are a burden.
      const bool is_wanted = choices_.topics.empty() ? !view_ : filter_.wants(message->topic);
      if (is_viewed || is_wanted) take(*message, is_viewed, is_wanted);
    }
    for (const std::string& problem : source_.problems()) warn(problem);
    check_names();
    if (view_) {
      const std::string told = view_->finish(write_);
      if (!told.empty()) fmt::print("{}\n", told);
    }
    if (taken_ == 0) {
      throw std::runtime_error(choices_.file + " has no message that prehend has, too; it takes " +
                               fmt::format("{}", fmt::join(ros::ros_types(), ", ")));
    }
    output_.finish(choices_.file);
    for (const auto& [topic, type] : left_out_) {
      fmt::print("{}: left out, as prehend has nothing like {}\n", topic, type);
    }
    return failed_ ? 1 : 0;
  }

 private:
  void take(const recording::RosRecordedMessage& message, bool is_viewed, bool is_wanted) {
    std::unique_ptr<google::protobuf::Message> made;
    const auto& known = ros::ros_types();
    if (std::find(known.begin(), known.end(), message.type) == known.end()) {
      left_out_[message.topic] = message.type;
      return;
    }
    try {
      made = ros::from_ros(message.type, message.read());
    } catch (const recording::RosError& error) {
      return warn(message.topic + ": " + error.what());
    } catch (const geometry::InputError& error) {
      return warn(message.topic + ": " + error.what());
    }
    ++taken_;
    if (is_viewed) view_->take(message.topic, message.time, *made, write_);
    if (is_wanted) output_.write(message.topic, message.time, *made);
  }

  void check_names() const {
    const std::vector<std::string> recorded(topics_.begin(), topics_.end());
    std::vector<std::string> named = choices_.stereo;
    for (const std::string& topic : {choices_.depth, choices_.color}) {
      if (!topic.empty()) named.push_back(topic);
    }
    std::optional<std::string> missing = filter_.unmatched(recorded);
    for (const std::string& topic : named) {
      if (topics_.count(topic) == 0) missing = topic;
    }
    if (missing) {
      throw std::runtime_error(choices_.file + " has no topic " + *missing +
                               text::nearest_match_hint(*missing, recorded));
    }
  }

  void warn(const std::string& problem) {
    failed_ = true;
    if (warned_.insert(problem).second) fmt::print(stderr, "bag import: {}\n", problem);
  }

  const BagImportChoices choices_;
  const recording::TopicFilter filter_;
  recording::RosRecording source_;
  Output output_;
  const ros::CameraPairing::Write write_ = [this](const std::string& topic, std::uint64_t time,
                                                  const google::protobuf::Message& message) {
    output_.write(topic, time, message);
  };
  std::unique_ptr<ros::CameraPairing> view_;
  std::set<std::string> topics_, warned_;
  std::map<std::string, std::string> left_out_;
  std::uint64_t taken_ = 0;
  bool failed_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes a recording of prehend of a recording of ROS", "bag_import");
  BagImportChoices choices;
  prehend::tools::add_bag_import_options(app, choices);
  try {
    app.parse(argc, argv);
    return Import(choices).run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "bag import: {}\n", error.what());
    return 1;
  }
}
