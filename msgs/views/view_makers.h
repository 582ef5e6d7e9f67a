#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "msgs/views/views.h"
#include "prehend/geometry/errors.h"

namespace prehend::views {

/// A channel of viewers' type `Converted`.
template <class Converted>
ViewChannel view_channel(const std::string& topic, std::size_t latched, bool may_drop) {
  return {topic, Converted::descriptor(), latched, may_drop};
}

/// The message, decoded. @throws geometry::InputError for another type or what is none.
template <class Message>
Message decoded(const ViewedMessage& raw) {
  Message message;
  if (raw.schema_name != Message::descriptor()->full_name() ||
      !message.ParseFromArray(raw.bytes.data(), static_cast<int>(raw.bytes.size()))) {
    throw geometry::InputError("A message on " + std::string(raw.topic) + " of " +
                                   std::string(raw.sender) + " is no " +
                                   Message::descriptor()->full_name(),
                               "Mend or update the node that published it");
  }
  return message;
}

/// Each message of one topic becomes one of the channel.
template <class Message, class Convert>
View simple_view(ViewChannel channel, const std::string& topic, Convert convert) {
  View view{std::move(channel), {topic}, {}};
  view.begin = [topic, convert](View::Publish publish) {
    return std::vector<View::Source>{
        {topic, [convert, publish](const ViewedMessage& raw) {
           publish(raw.publish_time, convert(decoded<Message>(raw)).SerializeAsString(), "");
         }}};
  };
  return view;
}

/// Leaves out what follows too soon. A time that has jumped back begins anew.
class Pace {
 public:
  explicit Pace(std::int64_t period) : period_(period) {}  // ns
  bool lets_through(std::int64_t now) {
    if (last_ && now >= *last_ && now - *last_ < period_) return false;
    last_ = now;
    return true;
  }

 private:
  std::int64_t period_;
  std::optional<std::int64_t> last_;
};

/// Objects by the look that they are of. Not thread-safe.
class Look {
 public:
  /// @param now [ns] when the message was published, @param stamp of its look, @param count of the
  /// look's objects. False: it is of a look before. `gone` gets the objects that were there and are
  /// no more. A time that has jumped back, as when a replay begins again, begins anew.
  bool take(std::int64_t now, std::int64_t stamp, std::uint32_t count,
            std::vector<std::uint32_t>& gone) {
    constexpr std::int64_t kJump = 1'000'000'000;  // ns
    began_anew_ = now < newest_ - kJump;
    if (began_anew_) {
      newest_ = now;
      stamp_ = kNever;
    }
    newest_ = std::max(newest_, now);
    if (stamp < stamp_) return false;
    if (stamp > stamp_) {
      for (std::uint32_t id = count; id < count_; ++id) gone.push_back(id);
      count_ = count;
      stamp_ = stamp;
    }
    return true;
  }
  std::int64_t stamp() const { return stamp_; }
  /// At the last take().
  bool began_anew() const { return began_anew_; }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();
  std::int64_t newest_ = 0;
  std::int64_t stamp_ = kNever;
  std::uint32_t count_ = 0;
  bool began_anew_ = false;
};

/// The parts of standard_views().
View frames_view(std::shared_ptr<const robot::Platform> platform);
View robot_view(std::shared_ptr<const robot::Platform> platform);
View objects_view();
View grasps_view();
View table_view();
View truth_view();

}  // namespace prehend::views
