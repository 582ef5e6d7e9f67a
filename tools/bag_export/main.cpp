// Writes the content of a recording as files that other programs read: what `prehend bag export`
// starts.

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/message_decoder.h"
#include "prehend/recording/topic_filter.h"
#include "prehend/text/nearest_match.h"
#include "tools/bag_export/field_columns.h"
#include "tools/bag_export/pictures.h"

namespace {

namespace fs = std::filesystem;
namespace recording = prehend::recording;
using google::protobuf::Message;

// The topic as path below `folder`; a recording must not write outside of it.
fs::path place_of(const fs::path& folder, const std::string& topic) {
  fs::path place = folder;
  for (const fs::path& part : fs::path(topic).relative_path()) {
    if (part == "." || part == ".." || part.empty()) {
      throw std::runtime_error("the topic name '" + topic + "' cannot be a file name");
    }
    place /= part;
  }
  if (place == folder) {
    throw std::runtime_error("the topic name '" + topic + "' cannot be a file name");
  }
  return place;
}

// [ns] header.stamp when the message has one, else 0.
std::int64_t stamp_of(const Message& message) {
  const auto* header = message.GetDescriptor()->FindFieldByName("header");
  if (!header || header->is_repeated() || !header->message_type()) return 0;
  const Message& part = message.GetReflection()->GetMessage(message, header);
  const auto* stamp = part.GetDescriptor()->FindFieldByName("stamp");
  if (!stamp || stamp->is_repeated() || stamp->cpp_type() != stamp->CPPTYPE_INT64) return 0;
  return part.GetReflection()->GetInt64(part, stamp);
}

class Export {
 public:
  Export(const std::string& file, fs::path folder, const std::vector<std::string>& topics)
      : reader_(file), folder_(std::move(folder)), filter_{topics, {}} {
    if (fs::exists(folder_) && !fs::is_empty(folder_)) {
      throw std::runtime_error(folder_.string() + " is not empty; give a new folder");
    }
    std::vector<std::string> recorded;
    for (const auto& [id, channel] : reader_.channels()) recorded.push_back(channel.topic);
    if (const auto pattern = filter_.unmatched(recorded)) {
      throw std::invalid_argument(file + " has no topic " + *pattern +
                                  prehend::text::nearest_match_hint(*pattern, recorded));
    }
    for (const auto& [id, schema] : reader_.schemas()) {
      const std::string problem = decoder_.add(schema);
      if (!problem.empty()) warn(problem);
    }
  }

  int run() {
    for_each_message([this](Topic& topic, const recording::McapMessage&, const Message& message) {
      topic.columns.add(message);
    });
    for (auto& [name, topic] : topics_) open(name, topic);
    for_each_message([this](Topic& topic, const recording::McapMessage& raw,
                            const Message& message) { write(topic, raw, message); });
    for (auto& [name, topic] : topics_) close(name, topic);
    for (const std::string& problem : reader_.problems()) warn(problem);
    return failed_ ? 1 : 0;
  }

 private:
  struct Topic {
    fs::path place;
    prehend::tools::FieldColumns columns;
    std::ofstream table;
    std::set<std::string> stems;
    std::uint64_t messages = 0;
    int pictures = 0;
  };

  void warn(const std::string& problem) {
    failed_ = true;
    if (warned_.insert(problem).second) fmt::print(stderr, "bag export: {}\n", problem);
  }

  template <class Work>
  void for_each_message(const Work& work) {
    recording::McapMessageFilter wanted;
    for (const auto& [id, channel] : reader_.channels()) {
      if (filter_.wants(channel.topic)) wanted.topics.push_back(channel.topic);
    }
    auto cursor = reader_.messages(wanted);
    while (const auto raw = cursor.next()) {
      const auto& channel = reader_.channels().at(raw->channel_id);
      const auto message = decoder_.decode(channel.schema_id, raw->data);
      if (!message) {
        warn(channel.topic +
             ": messages that are not protobuf of the recorded schema are left out");
        continue;
      }
      work(topics_[channel.topic], *raw, *message);
    }
  }

  void open(const std::string& name, Topic& topic) {
    topic.place = place_of(folder_, name);
    fs::create_directories(topic.place.parent_path());
    topic.table.open(topic.place.string() + ".csv", std::ios::binary);
    topic.table << "log_time,publish_time,sequence" << topic.columns.header() << "\n";
  }

  void write(Topic& topic, const recording::McapMessage& raw, const Message& message) {
    ++topic.messages;
    topic.table << fmt::format("{},{},{}{}\n", raw.log_time, raw.publish_time, raw.sequence,
                               topic.columns.row(message));
    const std::int64_t stamp = stamp_of(message);
    std::string stem = stamp != 0 ? fmt::to_string(stamp) : fmt::to_string(raw.publish_time);
    // Two messages of one stamp are told apart by their numbers.
    if (!topic.stems.insert(stem).second) stem += fmt::format("_{}", raw.sequence);
    try {
      topic.pictures += prehend::tools::write_pictures(message, topic.place / stem);
    } catch (const std::exception& error) {
      warn(fmt::format("{} message {}: {}", topic.place.string(), raw.sequence, error.what()));
    }
  }

  void close(const std::string& name, Topic& topic) {
    topic.table.close();
    if (!topic.table) throw std::runtime_error("cannot write " + topic.place.string() + ".csv");
    fmt::print("{}: {} messages to {}.csv{}\n", name, topic.messages, topic.place.string(),
               topic.pictures > 0
                   ? fmt::format(", {} files in {}/", topic.pictures, topic.place.string())
                   : "");
  }

  recording::McapReader reader_;
  const fs::path folder_;
  const recording::TopicFilter filter_;
  recording::MessageDecoder decoder_;
  std::map<std::string, Topic> topics_;
  std::set<std::string> warned_;
  bool failed_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Writes images of a recording as PNG, clouds as PCD, all other fields as CSV",
               "bag_export");
  std::string file, folder;
  std::vector<std::string> topics;
  app.add_option("file", file, "The recording (MCAP)")->required();
  app.add_option("folder", folder, "New folder to write to")->required();
  app.add_option("topics", topics, "Only these topics, * for any text");
  try {
    app.parse(argc, argv);
    return Export(file, folder, topics).run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "bag export: {}\n", error.what());
    return 1;
  }
}
