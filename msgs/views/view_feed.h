#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "msgs/views/view.h"

namespace prehend::views {

/// Makes the views of a recording, message by message, in the order that they come in. What needs
/// no topic is made at the first message. Not thread-safe.
class ViewFeed {
 public:
  /// Takes what a view has made. @param time ns, of the message that it was made of.
  using Write =
      std::function<void(const ViewChannel& channel, std::int64_t time, const std::string& bytes)>;
  /// Told why a message is not shown, once for each topic.
  using Warn = std::function<void(const std::string& problem)>;

  ViewFeed(std::vector<View> views, Write write, Warn warn);
  ViewFeed(const ViewFeed&) = delete;

  /// Messages of views themselves make none.
  void take(const ViewedMessage& message);

 private:
  void begin(const View& view);

  std::vector<View> views_;
  Write write_;
  Warn warn_;
  bool began_ = false;
  std::int64_t now_ = 0;  // ns, of the message that is taken
  std::map<std::string, std::vector<View::Take>, std::less<>> takes_;  // by topic
  std::map<std::string, View> pads_;                                   // by topic
  std::set<std::string, std::less<>> known_;                           // topics that have come
  std::set<std::string, std::less<>> warned_;
};

}  // namespace prehend::views
