#include "nodes/grasp_planning/model_batch.h"

#include <gtest/gtest.h>

namespace prehend::nodes {
namespace {

using std::chrono::seconds;

ModelBatch::Model model(std::uint32_t id, std::uint32_t count, std::int64_t stamp) {
  auto message = std::make_shared<msgs::ObjectModel>();
  message->set_id(id);
  message->set_object_count(count);
  message->mutable_header()->set_stamp(stamp);
  return message;
}

TEST(ModelBatch, WaitsForAllModelsOfAView) {
  ModelBatch batch(seconds(5));
  const ModelBatch::Time start{};
  batch.add(model(1, 2, 10), start);
  EXPECT_TRUE(batch.incomplete());
  EXPECT_TRUE(batch.take_ready(start + seconds(4)).empty());
  batch.add(model(0, 2, 10), start + seconds(4));
  const auto ready = batch.take_ready(start + seconds(4));
  ASSERT_EQ(ready.size(), 2u);
  EXPECT_EQ(ready[0]->id(), 0u);                              // in order of id, however they came
  EXPECT_TRUE(batch.take_ready(start + seconds(9)).empty());  // each once
}

TEST(ModelBatch, PatienceStartsAnewWithEachModel) {
  ModelBatch batch(seconds(5));
  const ModelBatch::Time start{};
  batch.add(model(0, 3, 10), start);
  batch.add(model(1, 3, 10), start + seconds(4));
  EXPECT_TRUE(batch.take_ready(start + seconds(8)).empty());
  EXPECT_EQ(batch.take_ready(start + seconds(9)).size(), 2u);
  EXPECT_TRUE(batch.incomplete());
  batch.add(model(2, 3, 10), start + seconds(20));
  EXPECT_EQ(batch.take_ready(start + seconds(20)).size(), 1u);
}

TEST(ModelBatch, ANewerViewReplacesAnOlderOne) {
  ModelBatch batch(seconds(5));
  const ModelBatch::Time start{};
  batch.add(model(0, 2, 10), start);
  batch.add(model(0, 1, 20), start);
  batch.add(model(1, 2, 10), start);  // late, of the older view
  const auto ready = batch.take_ready(start);
  ASSERT_EQ(ready.size(), 1u);
  EXPECT_EQ(ready[0]->header().stamp(), 20);
}

}  // namespace
}  // namespace prehend::nodes
