#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nodes/viewer/offers.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"
#include "prehend/viewing/types.h"

namespace prehend::nodes {

/// A channel of a well-known type that is made from topics of the graph while somebody looks.
struct View {
  /// Takes a message: its time [ns], its bytes, and what of it replaces the one before.
  using Publish =
      std::function<void(std::int64_t stamp, std::string bytes, const std::string& key)>;
  using Take = std::function<void(const graph::RawMessage&)>;
  struct Source {
    std::string topic;
    Take take;  // may throw: the message is left out, and said
  };

  viewing::Channel channel;
  /// It is offered once one of these is published; empty: always.
  std::vector<std::string> topics;
  /// Begins anew: publishes what needs no topic, and says what it listens to. One view's `take`s
  /// may run at once.
  std::function<std::vector<Source>(Publish)> begin;
};

/// Those that there always are: /viewer/frames, /viewer/robot (with a platform), cloud, objects,
/// grasps, table, image/left and right, depth, camera and log. docs/viewer.md has their content.
std::vector<View> standard_views(std::shared_ptr<const robot::Platform> platform);

/// /viewer/pad/NAME of a topic /tactile/NAME with tactile frames; nothing for another one.
std::optional<View> pad_view(const std::string& topic, const OfferedTopic& offered);

}  // namespace prehend::nodes
