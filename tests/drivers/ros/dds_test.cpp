// ROS 2's topics against another vendor's DDS, byte by byte: eProsima Fast DDS, on loopback.

#include "drivers/ros/transport/dds_peer.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>

#include "msgs/joints.pb.h"
#include "msgs/ros/from_ros.h"
#include "msgs/ros/to_ros.h"

namespace prehend::drivers::ros_link {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using testing::HasSubstr;

// Each process has a domain of its own, so that tests beside one another do not meet.
int own_domain() { return 100 + static_cast<int>(::getpid() % 100); }

bool eventually(const std::function<bool()>& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    if (is_so()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

/// Samples are the bytes of a payload, with its header.
class BytesType : public dds::TopicDataType {
 public:
  explicit BytesType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 16U << 20;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<std::string*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<std::string*>(data)->assign(reinterpret_cast<const char*>(payload->data),
                                            payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<std::string*>(data)->size()); };
  }
  void* createData() override { return new std::string; }
  void deleteData(void* data) override { delete static_cast<std::string*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

/// The other vendor's side.
class FastPeer {
 public:
  explicit FastPeer(int domain) {
    dds::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().user_transports.push_back(udp);
    // Loopback has no multicast: others are asked by their ports (RTPS 9.6.1).
    for (std::uint32_t i = 0; i < 8; ++i) {
      rtps::Locator_t locator;
      rtps::IPLocator::setIPv4(locator, 127, 0, 0, 1);
      locator.port = 7400 + 250 * static_cast<std::uint32_t>(domain) + 10 + 2 * i;
      qos.wire_protocol().builtin.initialPeersList.push_back(locator);
    }
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<dds::DomainId_t>(domain), qos);
    if (!participant_) throw std::runtime_error("Fast DDS does not begin");
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  ~FastPeer() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  dds::DataWriter* writer(const std::string& topic, const std::string& type, bool is_reliable) {
    dds::DataWriterQos qos;
    qos.reliability().kind =
        is_reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return publisher_->create_datawriter(this->topic(topic, type), qos);
  }
  dds::DataReader* reader(const std::string& topic, const std::string& type, bool is_latched) {
    dds::DataReaderQos qos;
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind =
        is_latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return subscriber_->create_datareader(this->topic(topic, type), qos);
  }
  static bool take(dds::DataReader& reader, std::string& bytes) {
    dds::SampleInfo info;
    return reader.take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK && info.valid_data;
  }

 private:
  dds::Topic* topic(const std::string& name, const std::string& type) {
    dds::TypeSupport(new BytesType(type)).register_type(participant_);
    return participant_->create_topic(name, type, dds::TOPIC_QOS_DEFAULT);
  }
  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
};

/// A sensor_msgs/JointState by the other vendor's serialiser. It leaves what lies between aligned
/// values as it finds it (CDR gives it no meaning), so it is given zeros, as ours writes.
std::string fast_joint_state(const std::vector<std::string>& names,
                             const std::vector<double>& positions) {
  std::string memory(4096, '\0');
  eprosima::fastcdr::FastBuffer buffer(memory.data(), memory.size());
  eprosima::fastcdr::Cdr cdr(buffer, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS,
                             eprosima::fastcdr::Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  cdr << std::int32_t{12} << std::uint32_t{34} << std::string("base");
  cdr << names << positions << std::vector<double>{} << std::vector<double>{};
  return {cdr.getBufferPointer(), cdr.getSerializedDataLength()};
}

msgs::JointState joint_state(const std::vector<std::string>& names,
                             const std::vector<double>& positions) {
  msgs::JointState joints;
  joints.mutable_header()->set_stamp(12'000'000'034);
  joints.mutable_header()->set_frame_id("base");
  for (const std::string& name : names) joints.add_name(name);
  for (const double position : positions) joints.add_position(position);
  return joints;
}

constexpr const char* kJointStateOfDds = "sensor_msgs::msg::dds_::JointState_";
const std::vector<std::string> kNames{"a", "elbow", "wrist_3"};
const std::vector<double> kPositions{0.5, -1e-9, 3};

class BesideFastDds : public testing::Test {
 protected:
  BesideFastDds()
      : fast_(own_domain()),
        peer_(connect_dds({.domain = own_domain()}, [this](const std::string& problem) {
          const std::lock_guard lock(mutex_);
          problems_ += problem + "\n";
        })) {}
  std::string problems() {
    const std::lock_guard lock(mutex_);
    return problems_;
  }
  std::mutex mutex_;
  std::string problems_;
  FastPeer fast_;
  std::unique_ptr<RosPeer> peer_;
};

TEST_F(BesideFastDds, WhatIsPublishedHereIsReadThereByteByByte) {
  auto* reader = fast_.reader("rt/joint_states", kJointStateOfDds, false);
  const auto publisher = peer_->advertise("/joint_states", "sensor_msgs/JointState", {});
  ASSERT_TRUE(eventually([&] { return publisher->readers() == 1; })) << problems();
  std::string bytes;
  ASSERT_TRUE(eventually([&] {
    publisher->publish(ros::to_ros(joint_state(kNames, kPositions), "sensor_msgs/JointState",
                                   ros::Version::kRos2));
    return FastPeer::take(*reader, bytes);
  }));
  // A payload ends at a multiple of four.
  const std::string expected = fast_joint_state(kNames, kPositions);
  ASSERT_GE(bytes.size(), expected.size());
  EXPECT_LT(bytes.size(), expected.size() + 4);
  EXPECT_EQ(bytes.substr(0, expected.size()), expected);
}

TEST_F(BesideFastDds, WhatIsPublishedThereIsReadHere) {
  std::mutex mutex;
  std::string told;
  const auto subscription = peer_->subscribe(
      "/joint_states", "sensor_msgs/JointState", {.is_reliable = false},
      [&](std::string_view bytes) {
        const auto message = ros::from_ros(
            "sensor_msgs/JointState", ros::type_of("sensor_msgs/JointState", ros::Version::kRos2)
                                          .read(bytes, recording::RosEncoding::kCdr));
        const std::lock_guard lock(mutex);
        told = message->SerializeAsString();
      });
  auto* writer = fast_.writer("rt/joint_states", kJointStateOfDds, true);
  ASSERT_TRUE(eventually([&] { return subscription->writers() == 1; })) << problems();
  ASSERT_TRUE(eventually([&] {
    std::string bytes = fast_joint_state(kNames, kPositions);
    writer->write(&bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const std::lock_guard lock(mutex);
    return !told.empty();
  }));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(told, joint_state(kNames, kPositions).SerializeAsString());
}

// Fragments on the wire.
TEST_F(BesideFastDds, LargeMessagesComeWholeBothWays) {
  const std::string type = "sensor_msgs::msg::dds_::PointCloud2_";
  std::string data(3'000'000, '\0');
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<char>(i * 7 + i / 1000);
  const std::string cloud =
      ros::type_of("sensor_msgs/PointCloud2", ros::Version::kRos2)
          .write(recording::RosValue(recording::RosValue::Fields{{"data", ros::ros_bytes(data)}}),
                 recording::RosEncoding::kCdr);
  auto* reader = fast_.reader("rt/cloud", type, true);
  const auto publisher =
      peer_->advertise("/cloud", "sensor_msgs/PointCloud2", {.is_latched = true, .depth = 1});
  publisher->publish(cloud);  // latched: whoever comes later gets it
  std::string bytes;
  ASSERT_TRUE(eventually([&] { return FastPeer::take(*reader, bytes); })) << problems();
  EXPECT_TRUE(bytes.substr(0, cloud.size()) == cloud);
  std::mutex mutex;
  std::string received;
  const auto subscription =
      peer_->subscribe("/back", "sensor_msgs/PointCloud2", {}, [&](std::string_view message) {
        const std::lock_guard lock(mutex);
        received = message;
      });
  auto* writer = fast_.writer("rt/back", type, true);
  ASSERT_TRUE(eventually([&] { return subscription->writers() == 1; }));
  // What is under way while the two meet may count as from before, and is nobody's.
  ASSERT_TRUE(eventually([&] {
    std::string sent = cloud;
    writer->write(&sent);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const std::lock_guard lock(mutex);
    return !received.empty();
  }));
  const std::lock_guard lock(mutex);
  EXPECT_TRUE(received.substr(0, cloud.size()) == cloud);
}

TEST_F(BesideFastDds, UnmatchedQualityOfServiceIsSaid) {
  const auto subscription = peer_->subscribe("/joint_states", "sensor_msgs/JointState",
                                             {.is_reliable = true}, [](std::string_view) {});
  fast_.writer("rt/joint_states", kJointStateOfDds, false);
  EXPECT_TRUE(eventually([&] { return problems().find("reliability") != std::string::npos; }))
      << problems();
  const auto publisher = peer_->advertise("/cloud", "sensor_msgs/PointCloud2", {});
  fast_.reader("rt/cloud", "sensor_msgs::msg::dds_::PointCloud2_", true);
  EXPECT_TRUE(eventually([&] { return problems().find("durability") != std::string::npos; }))
      << problems();
  EXPECT_EQ(subscription->writers(), 0U);
}

TEST_F(BesideFastDds, AnotherTypeOfATopicIsSaid) {
  const auto subscription =
      peer_->subscribe("/camera", "sensor_msgs/Image", {}, [](std::string_view) {});
  fast_.writer("rt/camera", "sensor_msgs::msg::dds_::CompressedImage_", true);
  EXPECT_TRUE(eventually([&] { return problems().find("CompressedImage_") != std::string::npos; }));
  EXPECT_THAT(problems(), HasSubstr("rt/camera"));
}

TEST(DdsPeer, ANetworkThatIsNoneIsRefusedInWords) {
  try {
    connect_dds({.domain = own_domain(), .network = "no<interface>"}, [](const std::string&) {});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no<interface>"));
  }
}

TEST(DdsPeer, NamesAreThoseOfRos2) {
  EXPECT_EQ(dds_topic_name("/a/b", RosChannel::kTopic), "rt/a/b");
  EXPECT_EQ(dds_topic_name("/a/_action/send_goal", RosChannel::kRequest),
            "rq/a/_action/send_goalRequest");
  EXPECT_EQ(dds_topic_name("/a/_action/send_goal", RosChannel::kReply),
            "rr/a/_action/send_goalReply");
}

}  // namespace
}  // namespace prehend::drivers::ros_link
