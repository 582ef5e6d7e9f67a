// Recordings as viewers draw them: what `prehend bag convert` starts.

#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "msgs/views/compressed_images.h"
#include "msgs/views/view_feed.h"
#include "msgs/views/views.h"
#include "prehend/recording/latched_messages.h"
#include "prehend/recording/protobuf_schema.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"
#include "tools/bag_convert/choices.h"
#include "tools/recording_copy.h"

namespace {

using namespace prehend;
using tools::BagConvertChoices;

constexpr const char* kJoints = "/joint_states";

views::ImageViews image_views(const std::string& images) {
  views::ImageViews shown;
  shown.shown = images != "none";
  if (images == "jpeg" || images == "png") {
    const auto format = images == "png" ? views::PictureFormat::kPng : views::PictureFormat::kJpeg;
    shown.compress = [format](const ::foxglove::RawImage& image) {
      return views::compressed_image(image, format);
    };
  }
  return shown;
}

std::vector<views::View> views_of(const BagConvertChoices& choices) {
  std::shared_ptr<const robot::Platform> platform;
  if (!choices.platform.empty()) {
    const std::string robots =
        choices.robots.empty() ? text::tree_file("config/robots") : choices.robots;
    platform = std::make_shared<const robot::Platform>(
        robot::read_platform(robot::platform_file(robots, choices.platform)));
  } else if (!choices.robots.empty()) {
    throw std::invalid_argument("--robots goes with --platform only");
  }
  return views::standard_views(platform, image_views(choices.images));
}

/// The views of one recording, into its copy.
class Conversion {
 public:
  explicit Conversion(const BagConvertChoices& choices)
      : choices_(choices),
        views_(views_of(choices)),
        reader_(choices.file),
        copy_(reader_, choices.output, options()),
        feed_(
            std::move(views_),
            [this](const views::ViewChannel& channel, std::int64_t time, const std::string& bytes) {
              write(channel, time, bytes);
            },
            [this](const std::string& problem) { problems_.push_back(problem); }) {}

  int run() {
    recording::TopicFilter kept{{}, {"/viewer/*"}};
    if (choices_.only_views) kept.exclude = {"*"};
    copy_.declare(kept);
    copy_.copy_attachments();
    copy_.writer().add_metadata({"prehend.convert", {{"from", choices_.file}}});
    auto cursor = reader_.messages({});
    std::uint64_t taken = 0;
    while (const auto message = cursor.next()) {
      copy_.write(*message, message->log_time);
      take(*message);
      ++taken;
    }
    if (shown_.empty()) {
      throw std::runtime_error(choices_.file + " has nothing that viewers draw (" +
                               std::to_string(taken) + " messages)");
    }
    const std::uint64_t written = copy_.finish();
    for (const auto& [topic, shown] : shown_) {
      fmt::print("{}: {} messages of {}\n", topic, shown.sequence, shown.type);
    }
    if (has_joints_ && choices_.platform.empty()) {
      fmt::print("the robot is not drawn: give it by --platform\n");
    }
    for (const std::string& problem : problems_) fmt::print("problem: {}\n", problem);
    fmt::print("{}: {} messages, {} of them for viewers\n", choices_.output, written, views_made_);
    return problems_.empty() && reader_.problems().empty() ? 0 : 1;
  }

 private:
  struct Shown {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
    std::string type;
  };

  recording::McapWriterOptions options() const {
    recording::McapWriterOptions options;
    options.compression = recording::compression_named(choices_.compression);
    return options;
  }

  void take(const recording::McapMessage& message) {
    const recording::McapChannel& channel = reader_.channels().at(message.channel_id);
    const auto* schema = reader_.schema_of(channel);
    if (channel.message_encoding != "protobuf" || schema == nullptr) return;
    has_joints_ = has_joints_ || channel.topic == kJoints;
    log_time_ = message.log_time;
    const auto time = static_cast<std::int64_t>(message.publish_time);
    feed_.take({channel.topic, choices_.file, schema->name, message.data, time, time});
  }

  void write(const views::ViewChannel& channel, std::int64_t time, const std::string& bytes) {
    const auto [found, is_new] = shown_.try_emplace(channel.topic);
    Shown& shown = found->second;
    if (is_new) {
      shown.type = channel.type->full_name();
      std::map<std::string, std::string> metadata;
      if (channel.kept() > 0) metadata[recording::kLatchedKey] = std::to_string(channel.kept());
      const std::uint16_t schema = copy_.writer().add_schema(
          shown.type, "protobuf", recording::file_descriptor_set(*channel.type));
      shown.channel = copy_.writer().add_channel(channel.topic, "protobuf", schema, metadata);
    }
    copy_.writer().write(shown.channel, ++shown.sequence, log_time_,
                         static_cast<std::uint64_t>(time), bytes);
    ++views_made_;
  }

  const BagConvertChoices choices_;
  std::vector<views::View> views_;
  recording::McapReader reader_;
  tools::RecordingCopy copy_;
  views::ViewFeed feed_;
  std::map<std::string, Shown> shown_;  // by topic
  std::uint64_t log_time_ = 0;          // ns, of the message that is taken
  std::uint64_t views_made_ = 0;
  bool has_joints_ = false;
  std::vector<std::string> problems_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes a recording for Foxglove and Lichtblick of one of prehend", "bag_convert");
  BagConvertChoices choices;
  tools::add_bag_convert_options(app, choices);
  try {
    app.parse(argc, argv);
    return Conversion(choices).run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "bag convert: {}\n", error.what());
    return 1;
  }
}
