#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Descriptor;
}

namespace prehend::views {

/// A message of a graph or of a recording.
struct ViewedMessage {
  std::string_view topic, sender, schema_name, bytes;
  std::int64_t publish_time = 0;  // ns
  /// ns, of a clock that goes on: what tells a state leaves out messages that follow too soon by
  /// it. Live that of the machine, in a recording that of the messages.
  std::int64_t pace_time = 0;
};

struct ViewChannel {
  std::string topic;
  const google::protobuf::Descriptor* type = nullptr;
  std::size_t latched = 0;  // messages that late viewers get
  bool may_drop = false;    // a slow viewer may miss some

  /// How many messages a recording repeats where it is split or cut: of scenes, which are told by
  /// parts, what makes up one.
  std::size_t kept() const { return latched > 0 && !may_drop ? 32 : latched; }
};

/// Whether it is the channel of a view.
inline bool is_view(std::string_view topic) { return topic.starts_with("/viewer/"); }

/// A channel of a well-known type that is made from topics.
struct View {
  /// Takes a message: its time [ns], its bytes, and what of it replaces the one before.
  using Publish =
      std::function<void(std::int64_t stamp, std::string bytes, const std::string& key)>;
  using Take = std::function<void(const ViewedMessage&)>;
  struct Source {
    std::string topic;
    Take take;  // may throw: the message is left out, and said
  };

  ViewChannel channel;
  /// It is offered once one of these is published; empty: always.
  std::vector<std::string> topics;
  /// Begins anew: publishes what needs no topic, at time 0, and says what it listens to. One view's
  /// `take`s may run at once.
  std::function<std::vector<Source>(Publish)> begin;
};

}  // namespace prehend::views
