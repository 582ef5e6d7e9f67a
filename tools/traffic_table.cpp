#include "tools/traffic_table.h"

#include <fmt/format.h>

#include "tools/table.h"

namespace prehend::tools {
namespace {

// "-" for none, so that losses catch the eye.
std::string counted(std::uint64_t number) { return number == 0 ? "-" : std::to_string(number); }

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 10'000) return fmt::format("{} B", bytes);
  if (bytes < 10'000'000) return fmt::format("{:.1f} kB", static_cast<double>(bytes) * 1e-3);
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) * 1e-6);
}

}  // namespace

void print_traffic(const std::string& first_column, const std::vector<TopicEndView>& ends) {
  std::vector<std::vector<std::string>> rows{{first_column, "QOS", "RATE", "MESSAGES", "DATA",
                                              "PEERS", "DROPPED", "SUPERSEDED", "MISSED", "DAMAGED",
                                              "HIGHEST QUEUE"}};
  for (const TopicEndView& view : ends) {
    std::vector<std::string> row{
        first_column == "NODE" ? view.node->record.name() : view.end.topic(), qos_text(view.end)};
    if (const auto* topic = view.statistics) {
      row.insert(
          row.end(),
          {fmt::format("{:.1f}/s", topic->rate()), std::to_string(topic->messages()),
           bytes_text(topic->bytes()), std::to_string(topic->peers()), counted(topic->dropped()),
           counted(topic->superseded()), counted(topic->missed()), counted(topic->malformed()),
           topic->queue_high_water() == 0
               ? "-"
               : fmt::format("{} ({})", topic->queue_high_water(),
                             bytes_text(topic->queue_high_water_bytes()))});
    } else {
      row.insert(row.end(), 9, "?");
    }
    rows.push_back(std::move(row));
  }
  print_table(rows);
}

}  // namespace prehend::tools
