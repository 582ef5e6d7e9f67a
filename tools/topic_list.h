#pragma once

#include <string>

namespace prehend::tools {

/// Prints all topics. Throws std::runtime_error when the registry does not answer.
void list_topics(const std::string& registry, bool json);

/// Prints one topic's type, publishers and subscribers with QoS, rates, losses and queue high-water
/// marks. Throws std::runtime_error, naming the nearest, when there is no such topic.
void show_topic(const std::string& registry, const std::string& topic, bool json);

}  // namespace prehend::tools
