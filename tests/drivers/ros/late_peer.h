#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "tests/drivers/ros/memory_peer.h"

namespace prehend::drivers::ros_link {

/// A peer that delivers in a thread of its own, as those with a wire do.
class LatePeer : public RosPeer {
 public:
  explicit LatePeer(ros::Version version) : peer_(version), thread_([this] { run(); }) {}
  ~LatePeer() override {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    news_.notify_all();
    thread_.join();
  }
  ros::Version version() const override { return peer_.version(); }
  std::unique_ptr<RosPublisher> advertise(const std::string& name, const std::string& type,
                                          const RosQos& qos, RosChannel channel) override {
    return std::make_unique<Late>(*this, peer_.advertise(name, type, qos, channel));
  }
  std::unique_ptr<RosSubscription> subscribe(const std::string& name, const std::string& type,
                                             const RosQos& qos,
                                             std::function<void(std::string_view)> take,
                                             RosChannel channel) override {
    return peer_.subscribe(name, type, qos, std::move(take), channel);
  }
  /// Until all that was published has been taken.
  void settle() {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return waiting_.empty() && !busy_; });
  }

 private:
  class Late : public RosPublisher {
   public:
    Late(LatePeer& peer, std::unique_ptr<RosPublisher> to) : peer_(peer), to_(std::move(to)) {}
    void publish(std::string bytes) override {
      {
        const std::lock_guard lock(peer_.mutex_);
        peer_.waiting_.emplace_back([to = to_, bytes] { to->publish(bytes); });
      }
      peer_.news_.notify_all();
    }
    std::size_t readers() const override { return to_->readers(); }

   private:
    LatePeer& peer_;
    std::shared_ptr<RosPublisher> to_;
  };
  void run() {
    std::unique_lock lock(mutex_);
    while (true) {
      news_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      const auto work = std::move(waiting_.front());
      waiting_.pop_front();
      busy_ = true;
      lock.unlock();
      work();
      lock.lock();
      busy_ = false;
      done_.notify_all();
    }
  }
  MemoryPeer peer_;
  std::mutex mutex_;
  std::condition_variable news_, done_;
  std::deque<std::function<void()>> waiting_;
  bool ends_ = false, busy_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::ros_link
