#include "bench/graph/soak.h"

#include <fmt/core.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>

#include "bench/graph/report.h"
#include "bench/graph/worker_pair.h"

namespace prehend::bench {
namespace {

constexpr double kFlat = 0.05;         // of the median
constexpr double kWarmUpShare = 0.15;  // of the time, not judged

struct MemorySample {
  double seconds = 0.0;
  double megabytes = 0.0;
};

/// Resident memory of a process over time, shared memory that it maps included.
class MemoryCurve {
 public:
  MemoryCurve(std::string name, int pid) : name_(std::move(name)), pid_(pid) {}

  void sample(double seconds) {
    std::ifstream status(fmt::format("/proc/{}/status", pid_));
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with("VmRSS:"))
        samples_.push_back({seconds, std::stod(line.substr(6)) / 1024});
    }
  }
  double last() const { return samples_.empty() ? 0.0 : samples_.back().megabytes; }

  /// Judges the samples between the warm-up and `end` [s]: flat when the median of every quarter of
  /// that time is within kFlat of the median of all. Single peaks are messages that wait in queues.
  std::string verdict(double end) {
    std::vector<double> values;
    for (const MemorySample& sample : samples_) {
      if (sample.seconds >= kWarmUpShare * end && sample.seconds <= end) {
        values.push_back(sample.megabytes);
      }
    }
    const auto quarter = static_cast<std::ptrdiff_t>(values.size() / 4);
    if (quarter == 0) return name_ + ": too few samples of its memory";
    median_ = percentile(values, 0.5);
    low_ = *std::min_element(values.begin(), values.end());
    high_ = *std::max_element(values.begin(), values.end());
    flat_ = true;
    std::string quarters;
    for (std::ptrdiff_t i = 0; i < 4; ++i) {
      const auto begin = values.begin() + i * quarter;
      const double deviation = percentile({begin, begin + quarter}, 0.5) / median_ - 1.0;
      flat_ = flat_ && std::abs(deviation) <= kFlat;
      quarters += fmt::format("{}{:+.1f}", i == 0 ? "" : ", ", 100 * deviation);
    }
    return fmt::format(
        "{:<9} RSS {:.1f} MB median ({:.1f} to {:.1f}), medians of the four quarters {} % of it: "
        "{}",
        name_, median_, low_, high_, quarters, flat_ ? "flat within 5 %" : "NOT FLAT");
  }
  bool flat() const { return flat_; }

  std::string json() const {
    std::string text = fmt::format(
        "{{\"process\": \"{}\", \"median_mb\": {:.2f}, \"min_mb\": {:.2f}, \"max_mb\": {:.2f}, "
        "\"flat\": {}, \"seconds_mb\": [",
        name_, median_, low_, high_, flat_);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      text += fmt::format("{}[{:.1f}, {:.2f}]", i == 0 ? "" : ", ", samples_[i].seconds,
                          samples_[i].megabytes);
    }
    return text + "]}";
  }

 private:
  std::string name_;
  int pid_;
  std::vector<MemorySample> samples_;
  double median_ = 0.0, low_ = 0.0, high_ = 0.0;
  bool flat_ = false;
};

using Figures = std::map<std::string, double>;

std::int64_t figure(const Figures& figures, const std::string& key) {
  const auto found = figures.find(key);
  return found == figures.end() ? 0 : static_cast<std::int64_t>(found->second);
}

/// What became of one topic's messages, summed over its readers.
struct TopicAccount {
  std::string topic;
  std::int64_t published = 0, readers = 0, delivered = 0, dropped_by_readers = 0,
               dropped_by_publisher = 0, malformed = 0, called = 0;
  /// Messages of which nobody says what became.
  std::int64_t unaccounted() const {
    return published * readers - delivered - dropped_by_readers - dropped_by_publisher - malformed;
  }
  bool exact() const { return published > 0 && unaccounted() == 0 && called == delivered; }
};

TopicAccount account(const Figures& figures, const SoakTopic& topic) {
  const std::string publisher = std::string("publisher:") + topic.name;
  TopicAccount result{.topic = topic.name, .published = figure(figures, publisher + ":published")};
  result.dropped_by_publisher =
      figure(figures, publisher + ":dropped") + figure(figures, publisher + ":superseded");
  for (const char* reader : {"fast:", "slow:"}) {
    if (reader == std::string("slow:") && !topic.has_slow_subscriber) continue;
    const std::string key = reader + std::string(topic.name);
    ++result.readers;
    result.delivered += figure(figures, key + ":delivered");
    result.dropped_by_readers +=
        figure(figures, key + ":dropped") + figure(figures, key + ":superseded");
    result.malformed += figure(figures, key + ":malformed");
    result.called += figure(figures, key + ":calls");
  }
  return result;
}

std::string account_line(const TopicAccount& a) {
  return fmt::format("{:<14} {:>9} {:>7} {:>10} {:>12} {:>15} {:>10} {:>12}", a.topic, a.published,
                     a.readers, a.delivered, a.dropped_by_readers, a.dropped_by_publisher,
                     a.malformed, a.unaccounted());
}

std::string account_json(const TopicAccount& a) {
  return fmt::format(
      "{{\"topic\": {}, \"published\": {}, \"readers\": {}, \"delivered\": {}, "
      "\"dropped_by_readers\": {}, \"dropped_by_publisher\": {}, \"malformed\": {}, "
      "\"unaccounted\": {}}}",
      json_quote(a.topic), a.published, a.readers, a.delivered, a.dropped_by_readers,
      a.dropped_by_publisher, a.malformed, a.unaccounted());
}

/// Samples both memories until both outputs have ended.
void watch(WorkerProcess& receiver, WorkerProcess& sender, MemoryCurve& receiver_memory,
           MemoryCurve& sender_memory, double seconds) {
  const std::int64_t begin = monotonic_now();
  const double interval = std::max(0.1, seconds / 600.0);
  double next_sample = 0.0;
  double next_word = 0.0;
  bool receiver_open = true;
  bool sender_open = true;
  while ((receiver_open || sender_open) && !interrupted) {
    const double elapsed = static_cast<double>(monotonic_now() - begin) * 1e-9;
    if (elapsed > 1.5 * seconds + 120.0) return;
    if (elapsed >= next_sample) {
      next_sample += interval;
      receiver_memory.sample(elapsed);
      sender_memory.sample(elapsed);
    }
    if (elapsed >= next_word) {
      next_word += std::max(1.0, seconds / 20.0);
      std::cerr << fmt::format("[{:.0f} s of {:.0f}] RSS: sender {:.1f} MB, receiver {:.1f} MB\n",
                               elapsed, seconds, sender_memory.last(), receiver_memory.last());
    }
    pollfd entries[] = {{receiver_open ? receiver.output() : -1, POLLIN, 0},
                        {sender_open ? sender.output() : -1, POLLIN, 0}};
    if (poll(entries, 2, 50) <= 0) continue;
    if (entries[0].revents != 0) receiver_open = receiver.read_output();
    if (entries[1].revents != 0) sender_open = sender.read_output();
  }
}

std::string json_soak(const std::vector<TopicAccount>& accounts, const MemoryCurve& sender,
                      const MemoryCurve& receiver, bool exact) {
  std::string topics;
  for (const TopicAccount& a : accounts) {
    topics += (topics.empty() ? "\n      " : ",\n      ") + account_json(a);
  }
  return "{\n" + json_context() +
         ",\n  \"benchmarks\": [],\n  \"soak\": {\n    \"exact\": " + (exact ? "true" : "false") +
         ",\n    \"topics\": [" + topics + "],\n    \"memory\": [\n      " + sender.json() +
         ",\n      " + receiver.json() + "]\n  }\n}\n";
}

}  // namespace

int run_soak(const std::string& program, double seconds, const std::string& json) {
  if (!json.empty()) write_file(json, "");
  const Job job{"soak", 0, seconds};
  const ChannelEnds ends = make_channel();
  WorkerProcess receiver(program, worker_arguments("receiver", job), ends.receiver);
  WorkerProcess sender(program, worker_arguments("sender", job), ends.sender);
  close_ends(ends);
  MemoryCurve receiver_memory("receiver", receiver.pid());
  MemoryCurve sender_memory("sender", sender.pid());
  watch(receiver, sender, receiver_memory, sender_memory, seconds);
  const std::int64_t deadline = monotonic_now() + 5'000'000'000;
  const bool receiver_ok = receiver.finish(deadline);
  const bool sender_ok = sender.finish(deadline);
  if (interrupted) throw BenchError("interrupted; nothing written");
  if (!receiver_ok || !sender_ok) throw BenchError("the soak failed: a process of it did");

  WorkerOutput output;
  parse_output(sender.text(), output);
  parse_output(receiver.text(), output);
  std::vector<TopicAccount> accounts;
  std::cout << fmt::format("{:<14} {:>9} {:>7} {:>10} {:>12} {:>15} {:>10} {:>12}\n", "topic",
                           "published", "readers", "delivered", "reader drops", "publisher drops",
                           "malformed", "unaccounted");
  for (const SoakTopic& topic : kSoakTopics) {
    accounts.push_back(account(output.figures, topic));
    std::cout << account_line(accounts.back()) << "\n";
  }
  const bool exact = std::all_of(accounts.begin(), accounts.end(),
                                 [](const TopicAccount& a) { return a.exact(); });
  std::cout << sender_memory.verdict(seconds) << "\n" << receiver_memory.verdict(seconds) << "\n";
  std::cout << (exact ? "every message is accounted for\n" : "MESSAGES ARE UNACCOUNTED FOR\n");
  if (!json.empty()) {
    write_file(json, json_soak(accounts, sender_memory, receiver_memory, exact));
  }
  return exact && sender_memory.flat() && receiver_memory.flat() ? 0 : 1;
}

}  // namespace prehend::bench
