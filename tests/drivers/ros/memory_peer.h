#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "drivers/ros/transport/ros_peer.h"

namespace prehend::drivers::ros_link {

/// ROS in this process: what is published comes to each subscription at once, in the same thread.
class MemoryPeer : public RosPeer {
 public:
  explicit MemoryPeer(ros::Version version) : version_(version) {}
  ros::Version version() const override { return version_; }

  std::unique_ptr<RosPublisher> advertise(const std::string& name, const std::string& type,
                                          const RosQos&, RosChannel channel) override {
    return std::make_unique<Publisher>(*this, key(name, channel), type);
  }
  std::unique_ptr<RosSubscription> subscribe(const std::string& name, const std::string& type,
                                             const RosQos&,
                                             std::function<void(std::string_view)> take,
                                             RosChannel channel) override {
    return std::make_unique<Subscription>(*this, key(name, channel), type, std::move(take));
  }
  /// As somebody of ROS would.
  void publish(const std::string& name, const std::string& bytes) {
    deliver(key(name, RosChannel::kTopic), bytes);
  }

 private:
  static std::string key(const std::string& name, RosChannel channel) {
    return std::to_string(static_cast<int>(channel)) + name;
  }
  class Subscription;
  class Publisher : public RosPublisher {
   public:
    Publisher(MemoryPeer& peer, std::string topic, std::string type)
        : peer_(peer), topic_(std::move(topic)), type_(std::move(type)) {
      const std::lock_guard lock(peer_.mutex_);
      peer_.publishers_.insert(topic_);
    }
    ~Publisher() override {
      const std::lock_guard lock(peer_.mutex_);
      peer_.publishers_.erase(peer_.publishers_.find(topic_));
    }
    void publish(std::string bytes) override { peer_.deliver(topic_, bytes); }
    std::size_t readers() const override {
      const std::lock_guard lock(peer_.mutex_);
      return peer_.subscriptions_.count(topic_);
    }

   private:
    MemoryPeer& peer_;
    const std::string topic_, type_;
  };
  class Subscription : public RosSubscription {
   public:
    Subscription(MemoryPeer& peer, std::string topic, std::string,
                 std::function<void(std::string_view)> take)
        : peer_(peer), topic_(std::move(topic)), take_(std::move(take)) {
      const std::lock_guard lock(peer_.mutex_);
      peer_.subscriptions_.emplace(topic_, this);
    }
    ~Subscription() override {
      const std::lock_guard lock(peer_.mutex_);
      auto [at, end] = peer_.subscriptions_.equal_range(topic_);
      while (at != end && at->second != this) ++at;
      peer_.subscriptions_.erase(at);
    }
    std::size_t writers() const override {
      const std::lock_guard lock(peer_.mutex_);
      return peer_.publishers_.count(topic_);
    }
    void take(std::string_view bytes) { take_(bytes); }

   private:
    MemoryPeer& peer_;
    const std::string topic_;
    std::function<void(std::string_view)> take_;
  };
  void deliver(const std::string& topic, const std::string& bytes) {
    std::vector<Subscription*> all;
    {
      const std::lock_guard lock(mutex_);
      const auto [begin, end] = subscriptions_.equal_range(topic);
      for (auto at = begin; at != end; ++at) all.push_back(at->second);
    }
    for (Subscription* one : all) one->take(bytes);
  }

  const ros::Version version_;
  mutable std::mutex mutex_;
  std::multimap<std::string, Subscription*> subscriptions_;
  std::multiset<std::string> publishers_;
};

}  // namespace prehend::drivers::ros_link
