// prehend.Recording and prehend.RecordingWriter.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "prehend/geometry/errors.h"
#include "prehend/recording/latched_messages.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/mcap_writer.h"
#include "prehend/recording/protobuf_schema.h"
#include "prehend/recording/recording_file.h"
#include "prehend/recording/topic_filter.h"
#include "prehend/text/nearest_match.h"
#include "python/arrays.h"
#include "python/messages.h"

namespace prehend::python {
namespace {

using recording::McapError;
using recording::McapReader;

std::uint64_t nanoseconds_after(std::uint64_t begin, double seconds, const char* what) {
  if (!(seconds >= 0) || seconds > 9e9) {
    throw py::value_error(
        fmt::format("{} is {} s; give seconds after the beginning", what, seconds));
  }
  return begin + static_cast<std::uint64_t>(seconds * 1e9);
}

/// A message of a recording; it keeps what it was read from.
struct RecordedMessage {
  std::shared_ptr<McapReader> reader;
  recording::McapMessage message;

  const recording::McapChannel& channel() const {
    return reader->channels().at(message.channel_id);
  }
  std::string type() const {
    const auto* schema = reader->schema_of(channel());
    return schema ? schema->name : "";
  }
  py::object decoded() const {
    const auto* schema = reader->schema_of(channel());
    if (channel().message_encoding != "protobuf" || !schema || schema->encoding != "protobuf") {
      throw geometry::InputError("A message on " + channel().topic + " is not protobuf",
                                 "Take its bytes: data");
    }
    std::shared_ptr<google::protobuf::Message> made = make_message(schema->name, schema->data);
    if (!made->ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
      throw geometry::InputError("A message on " + channel().topic + " is no " + schema->name,
                                 "See prehend bag check");
    }
    return to_python(made);
  }
};

class RecordedMessages {
 public:
  RecordedMessages(std::shared_ptr<McapReader> reader, const recording::McapMessageFilter& filter)
      : reader_(std::move(reader)), cursor_(reader_->messages(filter)) {}
  RecordedMessage next() {
    std::optional<recording::McapMessage> message = cursor_.next();
    if (!message) throw py::stop_iteration();
    return {reader_, std::move(*message)};
  }

 private:
  std::shared_ptr<McapReader> reader_;
  recording::McapMessageCursor cursor_;
};

class Recording {
 public:
  explicit Recording(const std::filesystem::path& file) {
    try {
      const py::gil_scoped_release release;
      reader_ = std::make_shared<McapReader>(file.string());
    } catch (const McapError& error) {
      throw geometry::InputError(error.what(), "Give a recording (MCAP)");
    }
  }

  const McapReader& reader() const { return *reader_; }

  py::dict topics() const {
    py::dict topics;
    for (const auto& [id, channel] : reader_->channels()) {
      const auto* schema = reader_->schema_of(channel);
      const auto& counts = reader_->statistics().channel_message_counts;
      const auto count = counts.find(id);
      const std::uint64_t before =
          topics.contains(channel.topic.c_str())
              ? topics[channel.topic.c_str()].cast<py::tuple>()[1].cast<std::uint64_t>()
              : 0;
      topics[channel.topic.c_str()] = py::make_tuple(
          schema ? schema->name : "", before + (count == counts.end() ? 0 : count->second));
    }
    return topics;
  }

  RecordedMessages messages(const std::vector<std::string>& wanted, double start,
                            std::optional<double> end) const {
    const recording::TopicFilter filter{wanted, {}};
    std::vector<std::string> recorded;
    for (const auto& [id, channel] : reader_->channels()) recorded.push_back(channel.topic);
    if (const auto pattern = filter.unmatched(recorded)) {
      throw geometry::InputError(reader_->path() + " has no topic " + *pattern,
                                 text::nearest_match_mend(*pattern, recorded));
    }
    recording::McapMessageFilter range;
    for (const std::string& topic : recorded) {
      if (!wanted.empty() && filter.wants(topic)) range.topics.push_back(topic);
    }
    const std::uint64_t begin = reader_->statistics().message_start_time;
    range.start_time = nanoseconds_after(begin, start, "start");
    if (end) range.end_time = nanoseconds_after(begin, *end, "end");
    if (range.end_time < range.start_time) throw py::value_error("end must not be before start");
    return {reader_, range};
  }

  py::dict attachments() const {
    py::dict all;
    for (const auto& index : reader_->attachments()) {
      try {
        all[py::str(index.name)] = py::bytes(reader_->read_attachment(index).data);
      } catch (const McapError& error) {
        throw geometry::InputError(error.what(), "See prehend bag check");
      }
    }
    return all;
  }

  py::dict metadata() const {
    py::dict all;
    for (const auto& one : reader_->metadata()) all[py::str(one.name)] = py::cast(one.entries);
    return all;
  }

 private:
  std::shared_ptr<McapReader> reader_;
};

class RecordingWriter {
 public:
  RecordingWriter(const std::filesystem::path& file, const std::string& compression)
      : path_(file.string()) {
    if (compression != "none" && compression != "lz4" && compression != "zstd") {
      throw py::value_error("compression is '" + compression + "'; give none, lz4 or zstd");
    }
    if (std::filesystem::exists(path_)) {
      throw geometry::InputError("'" + path_ + "' exists", "Give a new file");
    }
    recording::McapWriterOptions options;
    options.compression = recording::compression_named(compression);
    try {
      recording::make_way(path_);
      writer_ = std::make_unique<recording::McapWriter>(recording::partial_path(path_), options);
    } catch (const McapError& error) {
      throw geometry::InputError(error.what(), "Give a file that can be written");
    }
  }

  void write(const std::string& topic, const py::object& message, std::int64_t time,
             const std::optional<std::string>& type, int latched) {
    if (!writer_) throw py::value_error("the recording '" + path_ + "' is closed");
    if (time < 0) throw py::value_error("time must not be negative [ns]");
    if (latched < 0) throw py::value_error("latched must not be negative");
    if (topic.empty() || topic.front() != '/') {
      throw py::value_error("the topic '" + topic + "' is to begin with /");
    }
    if (py::isinstance<RecordedMessage>(message)) {
      return copy(topic, py::cast<const RecordedMessage&>(message), time, latched);
    }
    const auto known = channels_.find(topic);
    std::string name = type.value_or("");
    if (name.empty() && known != channels_.end()) name = known->second.type;
    if (name.empty() && py::hasattr(message, "type_name")) {
      name = py::cast<std::string>(message.attr("type_name"));
    }
    if (name.empty()) {
      throw py::type_error("the type of " + topic + " is not known: give type=, or a Message");
    }
    std::unique_ptr<google::protobuf::Message> made = make_own_message(name);
    const std::string& full_name = made->GetDescriptor()->full_name();
    fill_message(message, made.get());
    add(topic, {full_name, "protobuf", recording::file_descriptor_set(*made->GetDescriptor())},
        "protobuf", made->SerializeAsString(), time, latched);
  }

  void close() {
    if (!writer_) return;
    const auto writer = std::move(writer_);
    writer->close();
    recording::give_name(path_);
  }

 private:
  struct Channel {
    std::uint16_t id = 0;
    std::string type;
    std::uint32_t count = 0;
  };
  struct Type {
    std::string name, encoding, data;
  };

  /// Whatever its type, as it is.
  void copy(const std::string& topic, const RecordedMessage& recorded, std::int64_t time,
            int latched) {
    const auto* schema = recorded.reader->schema_of(recorded.channel());
    add(topic, schema ? Type{schema->name, schema->encoding, schema->data} : Type{},
        recorded.channel().message_encoding, recorded.message.data, time, latched);
  }

  void add(const std::string& topic, const Type& type, const std::string& encoding,
           std::string_view data, std::int64_t time, int latched) {
    const auto [found, is_new] = channels_.try_emplace(topic);
    Channel& channel = found->second;
    if (is_new) {
      std::map<std::string, std::string> metadata;
      if (latched > 0) metadata[recording::kLatchedKey] = std::to_string(latched);
      const std::uint16_t schema = type.name.empty()
                                       ? std::uint16_t{0}
                                       : writer_->add_schema(type.name, type.encoding, type.data);
      channel = {writer_->add_channel(topic, encoding, schema, metadata), type.name, 0};
    } else if (channel.type != type.name) {
      throw py::type_error(topic + " has messages of " + channel.type + ", not " + type.name);
    }
    const auto stamp = static_cast<std::uint64_t>(time);
    writer_->write(channel.id, ++channel.count, stamp, stamp, data);
  }

  std::string path_;
  std::unique_ptr<recording::McapWriter> writer_;
  std::map<std::string, Channel> channels_;
};

}  // namespace

void bind_recordings(py::module_& m) {
  py::register_exception<McapError>(m, "RecordingError", PyExc_OSError);
  py::class_<RecordedMessage>(m, "RecordedMessage", "A message of a recording.")
      .def_property_readonly("topic", [](const RecordedMessage& r) { return r.channel().topic; })
      .def_property_readonly("type_name", &RecordedMessage::type, "Protobuf name of its type.")
      .def_property_readonly(
          "publish_time", [](const RecordedMessage& r) { return r.message.publish_time; },
          "When it was published [ns].")
      .def_property_readonly(
          "log_time", [](const RecordedMessage& r) { return r.message.log_time; },
          "When it was recorded [ns].")
      .def_property_readonly("sequence",
                             [](const RecordedMessage& r) { return r.message.sequence; })
      .def_property_readonly(
          "data", [](const RecordedMessage& r) { return py::bytes(std::string(r.message.data)); },
          "Its encoded bytes.")
      .def_property_readonly("message", &RecordedMessage::decoded,
                             "It as a Message. Raises InputError for one that is none.");
  py::class_<RecordedMessages>(m, "RecordedMessages", "Messages of a recording, one by one.")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &RecordedMessages::next);
  py::class_<Recording>(m, "Recording",
                        "A recording (MCAP), to be read in any order. What is damaged is left out "
                        "and said in `problems`.")
      .def(py::init<std::filesystem::path>(), py::arg("file"),
           "Raises InputError for a file that is no recording.")
      .def_property_readonly("topics", &Recording::topics,
                             "By name: (protobuf name of the type, number of messages).")
      .def(
          "messages", &Recording::messages, py::arg("topics") = std::vector<std::string>(),
          py::arg("start") = 0.0, py::arg("end") = py::none(),
          "Iterates over messages in the order in which they were recorded: of these topics (* for "
          "any text; none: all), from `start` to `end` [s] after the recording's beginning.")
      .def_property_readonly(
          "start_time",
          [](const Recording& r) { return r.reader().statistics().message_start_time; },
          "Of its first message [ns].")
      .def_property_readonly(
          "end_time", [](const Recording& r) { return r.reader().statistics().message_end_time; },
          "Of its last message [ns].")
      .def_property_readonly("attachments", &Recording::attachments, "By name: bytes.")
      .def_property_readonly("metadata", &Recording::metadata, "By name: a dict of str.")
      .def_property_readonly(
          "problems", [](const Recording& r) { return r.reader().problems(); },
          "What was damaged so far, in words.");
  py::class_<RecordingWriter>(
      m, "RecordingWriter",
      "Writes a recording (MCAP), which has its name once it is closed. Use it with `with`.")
      .def(py::init<std::filesystem::path, std::string>(), py::arg("file"),
           py::arg("compression") = "lz4", "compression: none, lz4 or zstd.")
      .def("write", &RecordingWriter::write, py::arg("topic"), py::arg("message"), py::arg("time"),
           py::arg("type") = py::none(), py::arg("latched") = 0,
           "Adds a message: a Message or a dict. time: [ns], when it was published. type: of "
           "prehend's messages, as 'JointState'; a topic's first message must tell it. latched: "
           "how many messages of the topic late readers get.")
      .def("close", &RecordingWriter::close,
           "Ends the recording. Raises RecordingError when it "
           "could not be written.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__", [](RecordingWriter& self, const py::args&) { self.close(); });
}

}  // namespace prehend::python
