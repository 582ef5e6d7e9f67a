#include "nodes/grasp_planning/model_batch.h"

#include <algorithm>
#include <utility>

namespace prehend::nodes {

void ModelBatch::add(Model model, Time now) {
  const std::int64_t stamp = model->header().stamp();
  if (stamp_ && stamp < *stamp_) return;
  if (!stamp_ || stamp > *stamp_) {
    stamp_ = stamp;
    models_.clear();
    taken_.clear();
    expected_ = 0;
  }
  newest_ = now;
  expected_ = std::max<std::size_t>(expected_, model->object_count());
  const std::uint32_t id = model->id();
  models_[id] = std::move(model);
}

bool ModelBatch::incomplete() const { return models_.size() < expected_; }

std::vector<ModelBatch::Model> ModelBatch::take_ready(Time now) {
  std::vector<Model> ready;
  if (incomplete() && now - newest_ < patience_) return ready;
  for (const auto& [id, model] : models_) {
    if (taken_.insert(id).second) ready.push_back(model);
  }
  return ready;
}

}  // namespace prehend::nodes
