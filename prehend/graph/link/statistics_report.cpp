#include "prehend/graph/link/statistics_report.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "prehend/graph/link/topic_sides.h"

namespace prehend::graph {
namespace {

using msgs::graph::NodeStatistics;
using msgs::graph::TopicStatistics;

constexpr std::chrono::seconds kPeriod{1};

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

double cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

StatisticsReport::StatisticsReport(const PublisherSide& publishers,
                                   const SubscriberSide& subscribers,
                                   std::function<void(NodeStatistics&)> publish)
    : publishers_(publishers), subscribers_(subscribers), publish_(std::move(publish)) {}

void StatisticsReport::tick(std::uint64_t malformed_frames, std::uint64_t control_dropped,
                            std::uint64_t failed_callbacks) {
  const auto now = std::chrono::steady_clock::now();
  const std::chrono::duration<double> elapsed = now - last_report_;
  if (elapsed < kPeriod) return;
  const bool is_first = last_report_ == Time{};
  last_report_ = now;
  NodeStatistics report;
  publishers_.fill(report);
  subscribers_.fill(report);
  set_rates(report, is_first ? 0 : elapsed.count());
  report.set_malformed_frames(malformed_frames);
  report.set_control_dropped(control_dropped);
  report.set_failed_callbacks(failed_callbacks);
  report.set_resident_bytes(resident_bytes());
  report.set_cpu_seconds(cpu_seconds());
  publish_(report);
}

void StatisticsReport::set_rates(NodeStatistics& report, double elapsed) {
  std::map<End, std::uint64_t> messages;
  for (TopicStatistics& topic : *report.mutable_topics()) {
    End end{topic.topic(), topic.is_publisher(), 0};
    while (!messages.try_emplace(end, topic.messages()).second) ++std::get<2>(end);
    const auto last = last_messages_.find(end);
    const std::uint64_t before = last == last_messages_.end() ? 0 : last->second;
    if (elapsed > 0 && topic.messages() >= before) {
      topic.set_rate(static_cast<double>(topic.messages() - before) / elapsed);
    }
  }
  last_messages_ = std::move(messages);
}

void PublisherSide::fill(NodeStatistics& report) const {
  for (const auto& [id, entry] : entries_) {
    if (entry.core->topic() == kStatisticsTopic) continue;
    const PublisherStatistics statistics = entry.core->statistics();
    TopicStatistics& topic = *report.add_topics();
    topic.set_topic(entry.core->topic());
    topic.set_is_publisher(true);
    topic.set_messages(statistics.published);
    topic.set_bytes(statistics.bytes);
    topic.set_queue_high_water(statistics.queue_high_water);
    topic.set_queue_high_water_bytes(statistics.queue_high_water_bytes);
    topic.set_slab_bytes(statistics.slab_bytes);
    topic.set_dropped(statistics.dropped);
    topic.set_superseded(statistics.superseded);
    topic.set_peers(static_cast<std::uint32_t>(statistics.subscribers));
  }
}

void SubscriberSide::fill(NodeStatistics& report) const {
  for (const auto& [id, entry] : entries_) {
    if (entry.core->topic() == kStatisticsTopic) continue;
    const SubscriptionStatistics statistics = entry.core->statistics();
    TopicStatistics& topic = *report.add_topics();
    topic.set_topic(entry.core->topic());
    topic.set_messages(statistics.received);
    topic.set_bytes(statistics.bytes);
    topic.set_queue_high_water(statistics.queue_high_water);
    topic.set_queue_high_water_bytes(statistics.queue_high_water_bytes);
    topic.set_dropped(statistics.dropped);
    topic.set_superseded(statistics.superseded);
    topic.set_missed(statistics.missed);
    topic.set_malformed(statistics.malformed);
    topic.set_peers(static_cast<std::uint32_t>(statistics.publishers));
  }
}

}  // namespace prehend::graph
