#pragma once

#include <string>
#include <vector>

#include "tools/graph_view.h"

namespace prehend::tools {

/// A table of topic ends with rates, losses and queue high-water marks. `first_column`: "NODE" or
/// "TOPIC", what tells the ends apart.
void print_traffic(const std::string& first_column, const std::vector<TopicEndView>& ends);

}  // namespace prehend::tools
