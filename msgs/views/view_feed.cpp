#include "msgs/views/view_feed.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "msgs/views/views.h"

namespace prehend::views {

ViewFeed::ViewFeed(std::vector<View> views, Write write, Warn warn)
    : views_(std::move(views)), write_(std::move(write)), warn_(std::move(warn)) {}

void ViewFeed::begin(const View& view) {
  const auto publish = [this, &view](std::int64_t stamp, const std::string& bytes,
                                     const std::string& /*key*/) {
    write_(view.channel, std::max(stamp, now_), bytes);
  };
  for (View::Source& source : view.begin(publish)) {
    takes_[source.topic].push_back(std::move(source.take));
  }
}

void ViewFeed::take(const ViewedMessage& message) {
  if (is_view(message.topic)) return;
  now_ = message.publish_time;
  if (!std::exchange(began_, true)) {
    for (const View& view : views_) begin(view);
  }
  if (known_.find(message.topic) == known_.end()) {
    const std::string topic(message.topic);
    known_.insert(topic);
    if (std::optional<View> pad = pad_view(topic, message.schema_name)) {
      begin(pads_.emplace(topic, std::move(*pad)).first->second);
    }
  }
  const auto found = takes_.find(message.topic);
  if (found == takes_.end()) return;
  for (const View::Take& take : found->second) {
    try {
      take(message);
    } catch (const std::exception& error) {
      if (warned_.emplace(message.topic).second) warn_(error.what());
    }
  }
}

}  // namespace prehend::views
