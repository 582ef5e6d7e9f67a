#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "msgs/actions.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/objects.pb.h"
#include "msgs/safety.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/touch.pb.h"
#include "msgs/views/views.h"
#include "nodes/viewer/bridge.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"

namespace prehend::nodes {

/// A small graph with a viewer, in one process: the node `talker` publishes one object on /models
/// (latched), and what a test has to say on /held/model, counts on /clock_like, tactile frames, has
/// the parameter `gain`, serves /talk and hears /from_viewer.
class ViewerGraph : public ::testing::Test {
 protected:
  ViewerGraph() {
    gain_ = talker_.declare_parameter<double>(
        {.name = "gain", .default_value = 1, .minimum = 0, .maximum = 100, .description = "of it"});
    models_ = talker_.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(4));
    held_ = talker_.advertise<msgs::ObjectModel>("/held/model", graph::QoS::latched(4));
    counts_ = talker_.advertise<msgs::Clock>("/clock_like", graph::QoS::queue(10));
    frames_ = talker_.advertise<msgs::TactileFrame>("/tactile/left", graph::QoS::queue(10));
    talk_ = talker_.serve<msgs::NamedThing, msgs::Acknowledge>(
        "/talk", [](const msgs::NamedThing& thing) {
          if (thing.name() == "badly") throw std::runtime_error("not badly");
          msgs::Acknowledge answer;
          answer.set_success(true);
          answer.set_reason("talked to " + thing.name());
          return answer;
        });
    hears_ = talker_.subscribe<msgs::NamedThing>("/from_viewer", graph::QoS::queue(10),
                                                 [this](const auto& thing) {
                                                   const std::lock_guard lock(mutex_);
                                                   heard_.push_back(thing->name());
                                                 });
    timer_ = talker_.create_timer(0.01, [this] {
      msgs::Clock count;
      count.set_time(++count_);
      counts_.publish(count);
    });
    talker_.spin_in_background();
    publish_model(3);
  }
  ~ViewerGraph() override { end_viewer(); }

  void start_viewer(bool control = true, const std::string& page = "docs") {
    viewer_ = std::make_unique<graph::Node>(options("viewer"));
    Bridge::Options its;
    its.server.port = 0;
    its.server.page = page;
    its.control = control;
    its.registry = registry_.endpoint();
    its.views = views::standard_views(nullptr);
    bridge_ = std::make_unique<Bridge>(*viewer_, std::move(its));
    viewer_->spin_in_background();
    ends_ = false;
    turns_ = std::thread([this] {
      for (int i = 0; !ends_; ++i) {
        bridge_->tell_time();
        if (i % 5 == 0) bridge_->look();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  }
  void end_viewer() {
    ends_ = true;
    if (turns_.joinable()) turns_.join();
    bridge_.reset();
    viewer_.reset();
  }

  void publish_model(std::uint32_t id) { models_.publish(model_of(id, 1, "")); }
  static msgs::ObjectModel model_of(std::uint32_t id, std::int64_t stamp,
                                    const std::string& method) {
    msgs::ObjectModel model;
    model.mutable_header()->set_stamp(stamp);
    model.set_method(method);
    model.set_id(id);
    model.set_object_count(id + 1);
    model.set_valid(true);
    *model.mutable_mesh() = convert::to_message(geometry::make_box({0.02, 0.04, 0.06}));
    return model;
  }
  std::uint16_t port() const { return bridge_->server().port(); }
  graph::NodeOptions options(const std::string& name) const {
    graph::NodeOptions options;
    options.name = name;
    options.registry = registry_.endpoint();
    options.log_level = graph::LogLevel::kError;
    return options;
  }
  std::vector<std::string> heard() const {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  graph::Node talker_{options("talker")};
  double gain_ = 0;
  mutable std::mutex mutex_;
  std::vector<std::string> heard_;
  std::int64_t count_ = 0;
  graph::Publisher<msgs::ObjectModel> models_, held_;
  graph::Publisher<msgs::Clock> counts_;
  graph::Publisher<msgs::TactileFrame> frames_;
  graph::Service talk_;
  graph::Subscription hears_;
  graph::Node::Timer timer_;
  std::unique_ptr<graph::Node> viewer_;
  std::unique_ptr<Bridge> bridge_;
  std::atomic<bool> ends_{false};
  std::thread turns_;
};

}  // namespace prehend::nodes
