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

#include "prehend/geometry/errors.h"
#include "prehend/recording/latched_messages.h"
#include "prehend/recording/mcap_writer.h"
#include "prehend/recording/protobuf_schema.h"
#include "prehend/recording/recording_file.h"
#include "prehend/recording/ros_recording.h"
#include "prehend/recording/topic_filter.h"
#include "prehend/text/nearest_match.h"
#include "tools/bag_import/choices.h"
#include "tools/bag_import/from_ros.h"

namespace {

namespace fs = std::filesystem;
namespace recording = prehend::recording;
using prehend::tools::BagImportChoices;
using namespace prehend;

constexpr std::int64_t kSameInstant = 2'000'000;  // ns between the images of a pair
constexpr std::int64_t kSameView = 50'000'000;    // ns between depth and its colours

/// Where image_transport and the drivers put the calibration of an image's camera.
std::string info_topic_of(std::string image) {
  for (const char* ending : {"/compressed", "/compressedDepth"}) {
    const std::string end = ending;
    if (image.size() > end.size() &&
        image.compare(image.size() - end.size(), end.size(), end) == 0) {
      image.erase(image.size() - end.size());
      break;
    }
  }
  return image.substr(0, image.rfind('/') + 1) + "camera_info";
}

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

/// Image and CameraInfo of one camera, the newest.
struct Camera {
  explicit Camera(const std::string& topic)
      : image_topic(topic), info_topic(info_topic_of(topic)) {}
  std::string image_topic, info_topic;
  std::optional<msgs::Image> image;
  std::optional<msgs::CameraInfo> info;
};

/// What nodes of prehend look at, made of one or two topics.
class View {
 public:
  virtual ~View() = default;
  virtual bool needs(const std::string& topic) const = 0;
  virtual void take(const std::string& topic, std::uint64_t time,
                    const google::protobuf::Message& message, Output& output) = 0;
  /// @throws std::runtime_error when nothing came of it.
  virtual void finish(Output& output) = 0;

 protected:
  static void require(bool came, const std::string& what) {
    if (!came) throw std::runtime_error(what);
  }
};

class StereoView : public View {
 public:
  StereoView(const std::string& left, const std::string& right) : left_(left), right_(right) {}
  bool needs(const std::string& topic) const override {
    return topic == left_.image_topic || topic == left_.info_topic || topic == right_.image_topic ||
           topic == right_.info_topic;
  }
  void take(const std::string& topic, std::uint64_t time, const google::protobuf::Message& message,
            Output& output) override {
    for (Camera* camera : {&left_, &right_}) {
      if (topic == camera->info_topic) take_info(*camera, message);
      if (topic == camera->image_topic) take_image(*camera, message);
    }
    if (!told_info_ && left_.info && right_.info) {
      msgs::CameraInfo info = *left_.info;
      info.set_baseline(right_.info->baseline());
      require(info.baseline() > 0, right_.info_topic +
                                       " has no baseline (P[3] is 0): the pair is not "
                                       "calibrated as one");
      output.write("/camera/info", time, info);
      told_info_ = true;
    }
    if (!left_.image || !right_.image) return;
    const std::int64_t apart = left_.image->header().stamp() - right_.image->header().stamp();
    if (std::abs(apart) > kSameInstant) {
      (apart < 0 ? left_ : right_).image.reset();  // its partner is missing
      ++single_;
      return;
    }
    output.write("/camera/stereo", time, tools::stereo_pair(*left_.image, *right_.image));
    left_.image.reset();
    right_.image.reset();
    ++pairs_;
  }
  void finish(Output&) override {
    require(pairs_ > 0, fmt::format("there is no pair of {} and {} whose stamps agree within 2 ms",
                                    left_.image_topic, right_.image_topic));
    require(told_info_, fmt::format("the calibration is missing: {} and {}", left_.info_topic,
                                    right_.info_topic));
    single_ += left_.image.has_value() + right_.image.has_value();
    if (single_ > 0) fmt::print("{} images without a partner were left out\n", single_);
  }

 private:
  static void take_info(Camera& camera, const google::protobuf::Message& message) {
    if (const auto* info = dynamic_cast<const msgs::CameraInfo*>(&message)) camera.info = *info;
  }
  void take_image(Camera& camera, const google::protobuf::Message& message) {
    const auto* image = dynamic_cast<const msgs::Image*>(&message);
    require(image != nullptr, camera.image_topic + " has no images of 8 bit");
    single_ += camera.image.has_value();  // the one before has no partner
    camera.image = *image;
  }

  Camera left_, right_;
  bool told_info_ = false;
  int pairs_ = 0, single_ = 0;
};

class DepthView : public View {
 public:
  DepthView(const std::string& depth, std::string color)
      : depth_(depth), color_topic_(std::move(color)) {}
  bool needs(const std::string& topic) const override {
    return topic == depth_.image_topic || topic == depth_.info_topic || topic == color_topic_;
  }
  void take(const std::string& topic, std::uint64_t time, const google::protobuf::Message& message,
            Output& output) override {
    if (topic == color_topic_) {
      const auto* image = dynamic_cast<const msgs::Image*>(&message);
      require(image != nullptr, color_topic_ + " has no images of 8 bit");
      take_color(*image, output);
    }
    if (topic == depth_.info_topic && !told_info_) {
      output.write("/camera/info", time, message);
      told_info_ = true;
    }
    if (topic != depth_.image_topic) return;
    const auto* depth = dynamic_cast<const msgs::DepthImage*>(&message);
    require(depth != nullptr, depth_.image_topic + " has no depth (16UC1 or 32FC1)");
    if (waiting_) tell(output);
    waiting_ = *depth;
    waiting_time_ = time;
    // Nearer colours than the newest may come after it.
    if (color_topic_.empty() || apart(color_, *waiting_) <= kSameInstant) tell(output);
  }
  void finish(Output& output) override {
    if (waiting_) tell(output);
    require(images_ > 0, "there is no image on " + depth_.image_topic);
    require(told_info_, "the calibration is missing: " + depth_.info_topic);
    if (color_topic_.empty()) return;
    require(color_.has_value(), "there is no image on " + color_topic_);
    fmt::print("{} of {} depth images have colours\n", colored_, images_);
  }

 private:
  /// [ns] Between two stamps; without a colour more than any.
  static std::int64_t apart(const std::optional<msgs::Image>& color,
                            const msgs::DepthImage& depth) {
    if (!color) return std::numeric_limits<std::int64_t>::max();
    return std::abs(color->header().stamp() - depth.header().stamp());
  }
  void take_color(const msgs::Image& image, Output& output) {
    std::optional<msgs::Image> before = std::exchange(color_, image);
    if (!waiting_) return;
    const bool is_last = image.header().stamp() >= waiting_->header().stamp();
    if (apart(before, *waiting_) < apart(color_, *waiting_)) std::swap(color_, before);
    if (is_last) {
      tell(output);
      color_ = image;
    }
  }
  void tell(Output& output) {
    const bool is_colored = apart(color_, *waiting_) <= kSameView;
    output.write("/camera/depth", waiting_time_,
                 is_colored ? tools::colored(*waiting_, *color_) : *waiting_);
    ++images_;
    colored_ += is_colored;
    waiting_.reset();
  }

  const Camera depth_;
  const std::string color_topic_;
  std::optional<msgs::Image> color_;
  std::optional<msgs::DepthImage> waiting_;  // for its colours
  std::uint64_t waiting_time_ = 0;
  bool told_info_ = false;
  int images_ = 0, colored_ = 0;
};

class Import {
 public:
  explicit Import(const BagImportChoices& choices)
      : choices_(choices),
        filter_{choices.topics, {}},
        source_(choices.file),
        output_(choices.output, choices.compression) {
    if (!choices.stereo.empty()) {
      view_ = std::make_unique<StereoView>(choices.stereo[0], choices.stereo[1]);
    } else if (!choices.depth.empty()) {
      view_ = std::make_unique<DepthView>(choices.depth, choices.color);
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
    if (view_) view_->finish(output_);
    if (taken_ == 0) {
      throw std::runtime_error(choices_.file + " has no message that prehend has, too; it takes " +
                               fmt::format("{}", fmt::join(tools::ros_types(), ", ")));
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
    const auto& known = tools::ros_types();
    if (std::find(known.begin(), known.end(), message.type) == known.end()) {
      left_out_[message.topic] = message.type;
      return;
    }
    try {
      made = tools::from_ros(message.type, message.read());
    } catch (const recording::RosError& error) {
      return warn(message.topic + ": " + error.what());
    } catch (const geometry::InputError& error) {
      return warn(message.topic + ": " + error.what());
    }
    ++taken_;
    if (is_viewed) view_->take(message.topic, message.time, *made, output_);
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
  std::unique_ptr<View> view_;
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
