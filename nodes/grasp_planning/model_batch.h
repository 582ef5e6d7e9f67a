#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "msgs/objects.pb.h"

namespace prehend::nodes {

/// Collects the object models of one view, which arrive one by one in any order.
///
/// Models of one view have one stamp; each says how many there are. A view is ready when all have
/// come, or `patience` after the last one that came. A newer view takes the place of an older one.
class ModelBatch {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Model = std::shared_ptr<const msgs::ObjectModel>;

  explicit ModelBatch(std::chrono::duration<double> patience) : patience_(patience) {}

  void add(Model model, Time now);

  /// Models to plan on now, by id; each is given out once. Empty when not ready.
  std::vector<Model> take_ready(Time now);

  /// All models of the view that have come, by id.
  const std::map<std::uint32_t, Model>& models() const { return models_; }
  /// True when the view is not complete (yet).
  bool incomplete() const;

 private:
  std::chrono::duration<double> patience_;
  std::optional<std::int64_t> stamp_;  // ns, of the view
  Time newest_;                        // when the last model came
  std::map<std::uint32_t, Model> models_;
  std::set<std::uint32_t> taken_;
  std::size_t expected_ = 0;
};

}  // namespace prehend::nodes
