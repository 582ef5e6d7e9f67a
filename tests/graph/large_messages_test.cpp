// Large payloads: shared memory between processes, pointers within one, loans, batches.

#include <sys/mman.h>
#include <unistd.h>

#include <fstream>
#include <set>

#include "msgs/geometry.pb.h"
#include "msgs/objects.pb.h"
#include "prehend/graph/link/runtime_folder.h"
#include "prehend/graph/link/slab.h"
#include "prehend/graph/link/slab_mapping.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

constexpr std::size_t kLarge = 1'000'000;

class LargeMessages : public GraphTest {
 protected:
  // Nodes of one process that treat each other as if they were in two.
  NodeOptions apart(const std::string& name) const {
    NodeOptions result = options(name);
    result.use_pointers = false;
    return result;
  }
};

using Cloud = Received<msgs::PointCloud>;

class Clouds {
 public:
  std::function<void(const Cloud&)> taker() {
    return [this](const Cloud& m) {
      const std::lock_guard lock(mutex_);
      clouds_.push_back(m);
    };
  }
  std::vector<Cloud> all() const {
    const std::lock_guard lock(mutex_);
    return clouds_;
  }
  std::size_t size() const { return all().size(); }
  void clear() {
    const std::lock_guard lock(mutex_);
    clouds_.clear();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Cloud> clouds_;
};

void fill(std::span<std::uint8_t> bytes, std::uint8_t seed) {
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7 + seed);
}

bool holds(std::span<const std::uint8_t> bytes, std::size_t size, std::uint8_t seed) {
  if (bytes.size() != size) return false;
  for (std::size_t i = 0; i < size; ++i) {
    if (bytes[i] != static_cast<std::uint8_t>(i * 7 + seed)) return false;
  }
  return true;
}

// How many slabs this process has mapped from others: anonymous files named prehend-slab.
std::size_t slab_mappings() {
  std::ifstream maps("/proc/self/maps");
  std::size_t count = 0;
  for (std::string line; std::getline(maps, line);) {
    count += line.find("memfd:prehend-slab") != std::string::npos ? 1 : 0;
  }
  return count;
}

TEST_F(LargeMessages, EveryWayToPublishArrivesWhole) {
  for (const bool pointers : {false, true}) {
    for (const bool slab : {false, true}) {
      const std::string tail = std::to_string(pointers) + std::to_string(slab);
      NodeOptions options_a = options("talker" + tail), options_b = options("listener" + tail);
      options_a.use_pointers = options_b.use_pointers = pointers;
      options_a.use_slab = options_b.use_slab = slab;
      Node talker(options_a), listener(options_b);
      Clouds clouds;
      auto subscription =
          listener.subscribe<msgs::PointCloud>("/cloud", QoS::queue(10), clouds.taker());
      listener.spin_in_background();
      auto publisher = talker.advertise<msgs::PointCloud>("/cloud", QoS::queue(10));
      ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
      msgs::PointCloud cloud;
      cloud.set_count(5);
      std::vector<std::uint8_t> bytes(kLarge);
      fill(bytes, 3);
      msgs::PointCloud full = cloud;
      full.set_data(bytes.data(), bytes.size());
      publisher.publish(full);
      publisher.publish(msgs::PointCloud(full));
      publisher.publish(std::make_shared<const msgs::PointCloud>(full));
      publisher.publish(cloud, std::move(bytes));
      LoanedPayload loan = publisher.loan(kLarge);
      fill(loan.bytes(), 3);
      publisher.publish(cloud, std::move(loan));
      EXPECT_TRUE(loan.bytes().empty());
      publisher.publish_all(std::vector<msgs::PointCloud>{full, full});
      ASSERT_TRUE(eventually([&] { return clouds.size() == 7; })) << pointers << slab;
      for (const Cloud& received : clouds.all()) {
        EXPECT_TRUE(holds(received.payload(), kLarge, 3));
        EXPECT_EQ(received.body().count(), 5u);
        EXPECT_EQ(received->data(), full.data());
        EXPECT_EQ(received.shared()->SerializeAsString(), full.SerializeAsString());
      }
      EXPECT_EQ(subscription.statistics().missed, 0u);
      EXPECT_EQ(subscription.statistics().bytes, publisher.statistics().bytes);
      EXPECT_EQ(publisher.statistics().slab_bytes > 0, slab && !pointers);
    }
  }
}

TEST_F(LargeMessages, NodesOfOneProcessShareTheObject) {
  Node talker(options("talker")), listener(options("listener"));
  Clouds clouds;
  auto subscription =
      listener.subscribe<msgs::PointCloud>("/cloud", QoS::queue(10), clouds.taker());
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::PointCloud>("/cloud", QoS::queue(10));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  auto cloud = std::make_shared<msgs::PointCloud>();
  cloud->set_data(std::string(kLarge, 'x'));
  publisher.publish(std::shared_ptr<const msgs::PointCloud>(cloud));
  LoanedPayload loan = publisher.loan(kLarge);
  fill(loan.bytes(), 1);
  const std::uint8_t* lent = loan.bytes().data();
  publisher.publish({}, std::move(loan));
  ASSERT_TRUE(eventually([&] { return clouds.size() == 2; }));
  EXPECT_EQ(&*clouds.all()[0], cloud.get());
  EXPECT_EQ(clouds.all()[1].payload().data(), lent);
}

TEST_F(LargeMessages, AMessageOutlivesItsPublisher) {
  Node listener(apart("listener"));
  Clouds clouds;
  auto subscription =
      listener.subscribe<msgs::PointCloud>("/cloud", QoS::queue(10), clouds.taker());
  listener.spin_in_background();
  {
    Node talker(apart("talker"));
    auto publisher = talker.advertise<msgs::PointCloud>("/cloud", QoS::queue(10));
    ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
    LoanedPayload loan = publisher.loan(kLarge);
    fill(loan.bytes(), 9);
    publisher.publish({}, std::move(loan));
  }
  ASSERT_TRUE(eventually([&] { return clouds.size() == 1; }));
  EXPECT_TRUE(holds(clouds.all()[0].payload(), kLarge, 9));
  EXPECT_GT(slab_mappings(), 0u);
  clouds.clear();
  EXPECT_TRUE(eventually([&] { return slab_mappings() == 0; }));
}

// What a reader holds is never written again; what it lets go is.
TEST_F(LargeMessages, HeldMessagesStayAsTheyAreAndMemoryIsReused) {
  Node talker(apart("talker")), listener(apart("listener"));
  Clouds clouds;
  auto subscription =
      listener.subscribe<msgs::PointCloud>("/cloud", QoS::queue(100), clouds.taker());
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::PointCloud>("/cloud", QoS::queue(100));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  const auto send = [&](std::uint8_t seed) {
    LoanedPayload loan = publisher.loan(kLarge);
    fill(loan.bytes(), seed);
    publisher.publish({}, std::move(loan));
  };
  for (std::uint8_t i = 0; i < 5; ++i) send(i);
  ASSERT_TRUE(eventually([&] { return clouds.size() == 5; }));
  for (std::uint8_t i = 0; i < 5; ++i) EXPECT_TRUE(holds(clouds.all()[i].payload(), kLarge, i));
  clouds.clear();
  const std::size_t bytes = publisher.statistics().slab_bytes;
  for (int i = 0; i < 50; ++i) {
    send(static_cast<std::uint8_t>(i));
    ASSERT_TRUE(eventually([&] { return clouds.size() == 1; }));
    clouds.clear();
  }
  EXPECT_EQ(publisher.statistics().slab_bytes, bytes);
  EXPECT_TRUE(eventually([&] { return publisher.statistics().slab_bytes == 0; }, 10s));  // rested
}

TEST_F(LargeMessages, MemoryOfAKilledReaderIsUsedAgain) {
  Node talker(options("talker"));
  auto publisher = talker.advertise<msgs::PointCloud>("/big", QoS::queue(3));
  std::size_t most = 0;
  for (int round = 0; round < 3; ++round) {
    Child hoarder({"hoard", "--registry", endpoint});
    ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
    for (int i = 0; i < 8; ++i) {
      LoanedPayload loan = publisher.loan(kLarge);
      fill(loan.bytes(), 0);
      publisher.publish({}, std::move(loan));
      std::this_thread::sleep_for(5ms);
    }
    most = std::max(most, publisher.statistics().slab_bytes);
    hoarder.send(SIGKILL);
    hoarder.wait();
    ASSERT_TRUE(eventually([&] { return publisher.subscriber_count() == 0; }));
  }
  EXPECT_GE(most, 8 * kLarge);
  EXPECT_LT(most, 14 * kLarge);  // not another eight for each reader
  EXPECT_TRUE(eventually([&] { return publisher.statistics().slab_bytes == 0; }, 10s));
}

TEST_F(LargeMessages, LargeMessagesWithoutPayloadFieldUseSharedMemoryToo) {
  Node talker(apart("talker")), listener(apart("listener"));
  std::mutex mutex;
  std::vector<std::string> got;
  auto subscription = listener.subscribe<msgs::graph::Schema>(
      "/schema", QoS::queue(10), [&](const Received<msgs::graph::Schema>& m) {
        const std::lock_guard lock(mutex);
        got.push_back(m->SerializeAsString());
      });
  listener.spin_in_background();
  auto publisher = talker.advertise<msgs::graph::Schema>("/schema", QoS::queue(10));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
  msgs::graph::Schema message;
  message.set_name("n");
  message.set_descriptor_set(std::string(kLarge, 'd'));
  publisher.publish(message);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return got.size() == 1;
  }));
  EXPECT_EQ(got[0], message.SerializeAsString());
  EXPECT_GT(publisher.statistics().slab_bytes, kLarge);
}

TEST_F(LargeMessages, ManySmallOnesArriveInOrderWhoeverSendsThem) {
  for (const bool pointers : {false, true}) {
    const std::string tail = pointers ? "_near" : "_far";
    NodeOptions options_a = options("talker" + tail), options_b = options("listener" + tail);
    options_a.use_pointers = options_b.use_pointers = pointers;
    Node talker(options_a), listener(options_b);
    Inbox inbox;
    std::vector<MessageInfo> infos;
    auto subscription = listener.subscribe<msgs::Clock>("/many", QoS::queue(100000),
                                                        [&](const Received<msgs::Clock>& m) {
                                                          infos.push_back(m.info());
                                                          inbox.add(m->time());
                                                        });
    listener.spin_in_background();
    auto publisher = talker.advertise<msgs::Clock>("/many", QoS::queue(100000));
    ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
    std::vector<msgs::Clock> all;
    for (int i = 0; i < 20000; ++i) all.push_back(clock_message(i));
    publisher.publish_all(all);
    for (int i = 20000; i < 40000; ++i) publisher.publish(clock_message(i));
    ASSERT_TRUE(eventually([&] { return inbox.size() == 40000; }, 20s));
    listener.shutdown();
    const auto values = inbox.values();
    for (int i = 0; i < 40000; ++i) {
      ASSERT_EQ(values[static_cast<std::size_t>(i)], i);
      ASSERT_EQ(infos[static_cast<std::size_t>(i)].sequence, static_cast<std::uint64_t>(i + 1));
    }
    EXPECT_GT(infos.back().publish_time, 0);
    EXPECT_EQ(subscription.statistics().missed + subscription.statistics().dropped, 0u);
  }
}

TEST_F(LargeMessages, ALoanThatIsTooLargeIsRefused) {
  Node talker(options("talker"));
  auto publisher = talker.advertise<msgs::PointCloud>("/cloud", QoS::queue(1));
  EXPECT_THROW((void)publisher.loan(std::size_t{1} << 40), std::length_error);
  auto clock = talker.advertise<msgs::Clock>("/clock_like", QoS::queue(1));
  EXPECT_THROW(clock.publish({}, clock.loan(100)), std::invalid_argument);
  EXPECT_THROW(publisher.publish(std::shared_ptr<const msgs::PointCloud>()), std::invalid_argument);
}

// --- slabs by themselves
// --------------------------------------------------------------------------

msgs::graph::SlabContent content_of(const Slab& slab, std::size_t size) {
  msgs::graph::SlabContent content;
  content.set_pid(::getpid());
  content.set_file(slab.file());
  content.set_id(slab.id());
  content.set_generation(slab.generation());
  content.set_size(size);
  return content;
}

TEST(Slabs, ASlabIsFreeOnceEveryLeaseIsBack) {
  const auto pool = std::make_shared<SlabPool>(10 * kLarge);
  auto slab = pool->acquire(kLarge);
  ASSERT_TRUE(slab);
  SlabMappings mappings;
  slab->grant(1);
  slab->grant(2);
  EXPECT_TRUE(slab->has_grants());
  auto first = mappings.take_lease(content_of(*slab, 10), 1);
  ASSERT_TRUE(first.bytes) << first.error;
  EXPECT_FALSE(mappings.take_lease(content_of(*slab, 10), 1).bytes);  // granted once only
  auto second = mappings.take_lease(content_of(*slab, 10), 2);
  ASSERT_TRUE(second.bytes);
  EXPECT_FALSE(slab->has_grants());
  const SharedBytes copy = *first.bytes;
  first.bytes.reset();
  second.bytes.reset();
  EXPECT_FALSE(slab->is_free());  // a copy lives
  const std::uint64_t id = slab->id();
  slab.reset();
  EXPECT_NE(pool->acquire(kLarge)->id(), id);
}

TEST(Slabs, ALateReaderCannotTouchTheNextUse) {
  const auto pool = std::make_shared<SlabPool>(10 * kLarge);
  auto slab = pool->acquire(kLarge);
  SlabMappings mappings;
  slab->grant(1);
  auto lease = mappings.take_lease(content_of(*slab, 10), 1);
  const auto old = content_of(*slab, 10);
  slab->lose_reader(1, true);  // taken for dead
  slab.reset();
  slab = pool->acquire(kLarge);
  ASSERT_EQ(slab->id(), old.id());
  slab->grant(1);
  EXPECT_FALSE(mappings.take_lease(old, 1).bytes);
  lease.bytes.reset();  // gives back what is not its own any more
  EXPECT_TRUE(slab->has_grants());
  EXPECT_TRUE(mappings.take_lease(content_of(*slab, 10), 1).bytes);
}

TEST(Slabs, WhatIsAnnouncedWronglyIsRefused) {
  const auto pool = std::make_shared<SlabPool>(10 * kLarge);
  auto slab = pool->acquire(kLarge);
  slab->grant(1);
  const auto good = content_of(*slab, 10);
  const auto refuse = [&](const std::function<void(msgs::graph::SlabContent&)>& spoil,
                          std::uint32_t reader = 1) {
    SlabMappings mappings;
    auto content = good;
    spoil(content);
    const auto lease = mappings.take_lease(content, reader);
    EXPECT_FALSE(lease.bytes);
    EXPECT_FALSE(lease.error.empty());
  };
  refuse([](auto& c) { c.set_pid(0); });
  refuse([](auto& c) { c.set_pid(-1); });
  refuse([](auto& c) { c.set_pid(1 << 30); });
  refuse([](auto& c) { c.set_file(-5); });
  refuse([](auto& c) { c.set_file(0); });
  refuse([](auto& c) { c.set_file(1000000); });
  refuse([](auto& c) { c.set_id(c.id() + 1); });
  refuse([](auto& c) { c.set_generation(c.generation() + 1); });
  refuse([](auto& c) { c.set_size(std::uint64_t{1} << 60); });
  refuse([](auto& c) { c.set_offset(std::uint64_t{1} << 60); });
  refuse([](auto& c) { c.set_offset(~std::uint64_t{0}); });
  refuse([](auto&) {}, 0);
  refuse([](auto&) {}, 2);
  refuse([](auto&) {}, kMaxSlabReaders + 1);
  refuse([](auto&) {}, 0xffffffff);
  // A file of the right size that is no slab, and one that could be shrunk under the reader's feet.
  const int file = ::memfd_create("other", MFD_CLOEXEC);
  ASSERT_EQ(::ftruncate(file, kLarge), 0);
  refuse([&](auto& c) { c.set_file(file); });
  ::close(file);
  SlabMappings mappings;
  EXPECT_TRUE(mappings.take_lease(good, 1).bytes);
}

// Leases of messages that came after their subscription had ended were never given back.
TEST_F(LargeMessages, WhatComesForAnEndedSubscriptionIsGivenBack) {
  Node writer(apart("writer")), reader(apart("reader"));
  reader.spin_in_background();
  auto publisher = writer.advertise<msgs::PointCloud>("/cloud", QoS::queue(20));
  for (int round = 0; round < 20; ++round) {
    const auto subscription =
        reader.subscribe<msgs::PointCloud>("/cloud", QoS::queue(20), [](const Cloud&) {});
    ASSERT_TRUE(publisher.wait_for_subscribers(1, 5s));
    for (int i = 0; i < 10; ++i) publisher.publish({}, publisher.loan(kLarge));
  }
  EXPECT_TRUE(eventually([&] { return publisher.statistics().slab_bytes == 0; }, 20s));
}

TEST(Slabs, ThePoolIsBoundedAndReusesWhatFits) {
  const auto pool = std::make_shared<SlabPool>(4 * kLarge);
  std::vector<std::shared_ptr<Slab>> held;
  while (auto slab = pool->acquire(kLarge)) held.push_back(std::move(slab));
  EXPECT_GE(held.size(), 2u);
  EXPECT_LE(pool->bytes(), 4 * kLarge);
  EXPECT_FALSE(pool->acquire(100 * kLarge));
  const std::uint64_t id = held.back()->id();
  held.pop_back();
  EXPECT_EQ(pool->acquire(kLarge - 5000)->id(), id);
  held.clear();
  EXPECT_TRUE(pool->acquire(3 * kLarge));  // smaller ones make room
  pool->trim(0s);
  EXPECT_EQ(pool->bytes(), 0u);
}

}  // namespace
}  // namespace prehend::graph
