#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace prehend::testing {

/// The topics that traffic_node publishes and subscribes, each a PointCloud.
enum Topic : std::size_t { kSmall, kLarge, kLatched, kTopicCount };
inline constexpr std::array<const char*, kTopicCount> kTopicNames{"/small", "/large", "/latched"};
inline constexpr std::array<std::size_t, kTopicCount> kPayloadBytes{64, 1 << 20, 300 << 10};
inline constexpr std::size_t kSenders = 2;

/// What a subscriber knows of one publisher on one topic, its present process only.
struct SenderState {
  std::atomic<std::uint64_t> pid{0};
  std::atomic<std::uint64_t> received{0};
  std::atomic<std::uint64_t> first_sequence{0};
  std::atomic<std::uint64_t> last_sequence{0};
  std::atomic<std::int64_t> last_time{0};  ///< steady clock [ns]
};

/// What one traffic_node tells the test, in a file that both have mapped: it stays readable when
/// the node is killed, and needs nothing of the graph that is tested.
struct TrafficState {
  std::array<std::array<SenderState, kSenders>, kTopicCount> senders;
  struct Losses {
    std::atomic<std::uint64_t> gaps{0};     ///< sequence numbers that were left out
    std::atomic<std::uint64_t> missed{0};   ///< of the subscription's statistics
    std::atomic<std::uint64_t> counted{0};  ///< the same + dropped + superseded
    std::atomic<std::uint64_t> unseen{0};   ///< most gaps there ever were beyond those counted
  };
  std::array<Losses, kTopicCount> losses;
  std::atomic<std::uint64_t> damaged{0};    ///< messages whose content is not what was published
  std::atomic<std::uint64_t> reordered{0};  ///< messages not after the one before

  // Of a publisher:
  std::atomic<std::uint64_t> slowest_publish{0};  ///< [ns]
  std::atomic<std::uint64_t> most_slab_bytes{0};
};

/// A TrafficState in a file, mapped. Creates the file when it is not there.
class TrafficFile {
 public:
  explicit TrafficFile(const std::filesystem::path& path);
  ~TrafficFile();
  TrafficFile(const TrafficFile&) = delete;
  TrafficFile& operator=(const TrafficFile&) = delete;

  /// As at the start: of a process that takes another's place.
  void clear();
  TrafficState* operator->() const { return state_; }
  TrafficState& operator*() const { return *state_; }

 private:
  TrafficState* state_ = nullptr;
};

}  // namespace prehend::testing
