#include "drivers/ros/transport/roscpp_peer.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include <ros/ros.h>
#include <topic_tools/shape_shifter.h>

#include <fmt/format.h>

namespace prehend::drivers::ros_link {
namespace {

using topic_tools::ShapeShifter;

class RoscppPublisher : public RosPublisher {
 public:
  RoscppPublisher(::ros::NodeHandle& node, const std::string& name, const std::string& type,
                  const RosQos& qos)
      : type_(type),
        md5_(ros::md5_sum(type)),
        definition_(ros::definition(type, ros::Version::kRos1)),
        latched_(qos.is_latched) {
    ::ros::AdvertiseOptions options(name, static_cast<std::uint32_t>(qos.depth), md5_, type_,
                                    definition_);
    options.latch = qos.is_latched;
    publisher_ = node.advertise(options);
    if (!publisher_) throw std::runtime_error("ROS takes no topic '" + name + "'");
  }
  void publish(std::string bytes) override {
    ShapeShifter message;
    message.morph(md5_, type_, definition_, latched_ ? "1" : "0");
    ::ros::serialization::IStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                         static_cast<std::uint32_t>(bytes.size()));
    message.read(stream);
    publisher_.publish(message);
  }
  std::size_t readers() const override { return publisher_.getNumSubscribers(); }

 private:
  const std::string type_, md5_, definition_;
  const bool latched_;
  ::ros::Publisher publisher_;
};

class RoscppSubscription : public RosSubscription {
 public:
  RoscppSubscription(::ros::NodeHandle& node, const std::string& name, const std::string& type,
                     const RosQos& qos, std::function<void(std::string_view)> take, RosProblem tell)
      : name_(name),
        type_(type),
        md5_(ros::md5_sum(type)),
        take_(std::move(take)),
        tell_(std::move(tell)) {
    subscriber_ = node.subscribe<ShapeShifter>(
        name, static_cast<std::uint32_t>(qos.depth),
        [this](const ShapeShifter::ConstPtr& message) { receive(*message); });
    if (!subscriber_) throw std::runtime_error("ROS takes no subscription to '" + name + "'");
  }
  ~RoscppSubscription() override {
    const std::lock_guard lock(mutex_);  // waits for a callback that runs
    subscriber_.shutdown();
    take_ = nullptr;
  }
  std::size_t writers() const override { return subscriber_.getNumPublishers(); }

 private:
  void receive(const ShapeShifter& message) {
    const std::lock_guard lock(mutex_);
    if (!take_) return;
    if (message.getMD5Sum() != md5_) {
      if (!std::exchange(told_, true)) {
        tell_(fmt::format("{}: a peer sends {} ({}), the mapping has {} ({}): it is left out",
                          name_, message.getDataType(), message.getMD5Sum(), type_, md5_));
      }
      return;
    }
    std::string bytes(message.size(), '\0');
    ::ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                         static_cast<std::uint32_t>(bytes.size()));
    message.write(stream);
    take_(bytes);
  }

  const std::string name_, type_, md5_;
  std::mutex mutex_;  // guards the next two
  std::function<void(std::string_view)> take_;
  bool told_ = false;
  const RosProblem tell_;
  ::ros::Subscriber subscriber_;
};

class RoscppPeer : public RosPeer {
 public:
  RoscppPeer(const std::string& name, const std::string& master, double patience, RosProblem tell)
      : tell_(std::move(tell)) {
    std::map<std::string, std::string> remaps;
    if (!master.empty()) remaps["__master"] = master;
    ::ros::init(remaps, name, ::ros::init_options::NoSigintHandler | ::ros::init_options::NoRosout);
    wait_for_master(patience);
    node_ = std::make_unique<::ros::NodeHandle>();
    spinner_ = std::make_unique<::ros::AsyncSpinner>(2);
    spinner_->start();
    watcher_ = std::thread([this] { watch(); });
  }
  ~RoscppPeer() override {
    stops_ = true;
    watcher_.join();
    spinner_->stop();
    ::ros::shutdown();
  }
  ros::Version version() const override { return ros::Version::kRos1; }

  std::unique_ptr<RosPublisher> advertise(const std::string& name, const std::string& type,
                                          const RosQos& qos, RosChannel channel) override {
    require_topic(channel);
    return std::make_unique<RoscppPublisher>(*node_, name, type, qos);
  }
  std::unique_ptr<RosSubscription> subscribe(const std::string& name, const std::string& type,
                                             const RosQos& qos,
                                             std::function<void(std::string_view)> take,
                                             RosChannel channel) override {
    require_topic(channel);
    return std::make_unique<RoscppSubscription>(*node_, name, type, qos, std::move(take), tell_);
  }

 private:
  static void require_topic(RosChannel channel) {
    if (channel != RosChannel::kTopic) throw std::logic_error("ROS 1 has actions by topics alone");
  }
  static void wait_for_master(double patience) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
    while (!::ros::master::check()) {
      if (std::chrono::steady_clock::now() >= end) {
        throw std::runtime_error(
            fmt::format("no ROS master answers at {}: start roscore, or set `master`",
                        ::ros::master::getURI()));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  // A master that was started anew knows none of this node's topics.
  void watch() {
    constexpr int kTicks = 20;  // two seconds
    bool was_there = true;
    for (int tick = 1; !stops_; ++tick) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      if (tick % kTicks != 0) continue;
      const bool is_there = ::ros::master::check();
      if (was_there && !is_there) {
        tell_(
            fmt::format("the ROS master at {} is gone: what is connected goes on, nobody new "
                        "finds this node until it is started again after the master",
                        ::ros::master::getURI()));
      }
      was_there = is_there;
    }
  }

  const RosProblem tell_;
  std::unique_ptr<::ros::NodeHandle> node_;
  std::unique_ptr<::ros::AsyncSpinner> spinner_;
  std::atomic<bool> stops_ = false;
  std::thread watcher_;
};

}  // namespace

std::unique_ptr<RosPeer> connect_roscpp(const std::string& name, const std::string& master,
                                        double patience, RosProblem tell) {
  return std::make_unique<RoscppPeer>(name, master, patience, std::move(tell));
}

}  // namespace prehend::drivers::ros_link
