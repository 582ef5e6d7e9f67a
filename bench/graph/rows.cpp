#include "bench/graph/rows.h"

#include <algorithm>
#include <regex>

#include "bench/graph/job.h"
#include "prehend/text/nearest_match.h"

namespace prehend::bench {
namespace {

constexpr std::size_t kSmall = 100;
constexpr std::size_t kKilo = 1024;
constexpr std::size_t kMega = 1024 * 1024;
const std::vector<std::size_t> kAll = {kSmall, 64 * kKilo, 640 * kKilo, 4 * kMega, 16 * kMega};
const std::vector<std::size_t> kLarge = {64 * kKilo, 640 * kKilo, 4 * kMega, 16 * kMega};
const std::vector<std::size_t> kThree = {kSmall, 640 * kKilo, 4 * kMega};

}  // namespace

const std::vector<PeerKind>& peer_kinds() {
  static const std::vector<PeerKind> kinds = {
      {.name = "naive_cold",
       .description = "protobuf in one ZeroMQ frame, PAIR over ipc, glibc's heap as it is",
       .sizes = kAll},
      {.name = "naive_warm",
       .description = "the same with M_MMAP_THRESHOLD and M_TRIM_THRESHOLD raised",
       .sizes = kAll},
      {.name = "ros1",
       .description = "ROS 1 roscpp, PointCloud2 over loopback TCP (nodelay), thresholds raised",
       .sizes = kThree,
       .ros1 = true},
      {.name = "ring",
       .description = "boost::interprocess ring, one copy, a spinning reader: the limit",
       .sizes = kAll},
      {.name = "inline",
       .description = "our nodes, publish(const T&), shared memory off: frames over ipc",
       .sizes = kAll},
      {.name = "slab_copy",
       .description = "our nodes, publish(const T&): one copy into a slab",
       .sizes = kLarge},
      {.name = "slab_loaned",
       .description = "our nodes, loan() and publish(T, LoanedPayload&&); filling not counted",
       .sizes = kLarge},
      {.name = "same_process",
       .description = "our nodes in one process, publish(shared_ptr): hand-over of a pointer",
       .sizes = kThree,
       .same_process = true},
      {.name = "service",
       .description = "our nodes, service round trip, request of this size, small answer",
       .sizes = kThree,
       .service = true},
      {.name = "throughput_publish",
       .description = "our nodes, one publisher, publish(const T&) in a loop: messages/s",
       .sizes = {kSmall},
       .throughput = true},
      {.name = "throughput_publish_all",
       .description = "our nodes, one publisher, publish_all of 1024 at a time: messages/s",
       .sizes = {kSmall},
       .throughput = true},
  };
  return kinds;
}

std::string size_name(std::size_t bytes) {
  if (bytes >= kMega) return std::to_string(bytes / kMega) + "MB";
  if (bytes >= kKilo) return std::to_string(bytes / kKilo) + "KB";
  return std::to_string(bytes) + "B";
}

std::string Row::name() const { return kind->name + "/" + size_name(bytes); }

std::vector<Row> rows(const std::string& filter, bool with_ros1) {
  std::vector<Row> chosen;
  std::vector<std::string> names;
  try {
    const std::regex pattern(filter);
    for (const PeerKind& kind : peer_kinds()) {
      if (kind.ros1 && !with_ros1) continue;
      for (const std::size_t bytes : kind.sizes) {
        const Row row{&kind, bytes};
        names.push_back(row.name());
        if (std::regex_search(row.name(), pattern)) chosen.push_back(row);
      }
    }
  } catch (const std::regex_error&) {
    throw BenchError("--filter: '" + filter + "' is not a regular expression");
  }
  if (chosen.empty()) {
    throw BenchError("--filter: no row matches '" + filter + "'" +
                     text::nearest_match_hint(filter, names) + " (--list shows all)");
  }
  return chosen;
}

}  // namespace prehend::bench
