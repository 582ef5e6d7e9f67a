#include "eval/case_result.h"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

TEST(CaseResult, ComesBackAsItWasWritten) {
  CaseResult result;
  result.case_name = "household-can-045-seed1";
  result.group = "household";
  result.data_set = "can";
  result.orientation = 45;
  result.symmetric = false;
  result.points = 1234;
  result.mask_iou = 0.9;
  MethodResult good;
  good.method = "Ours";
  good.mean = 1.0 / 3;
  good.max = 1e-9;
  good.seconds = 0.25;
  good.watertight = true;
  good.evidence.emplace();
  good.evidence->method = shape::CompletionMethod::kExtrusion;
  good.evidence->support = 0.125;
  good.evidence->cut_by_image = true;
  MethodResult failed;
  failed.method = "Del";
  failed.problem = "it says: \"no\" \n- {odd} # text";
  result.methods = {good, failed};
  const CaseResult back = read_case_result(to_text(result));
  EXPECT_EQ(back.case_name, result.case_name);
  EXPECT_EQ(back.orientation, 45);
  EXPECT_FALSE(back.symmetric);
  EXPECT_EQ(back.points, 1234);
  ASSERT_EQ(back.methods.size(), 2U);
  EXPECT_EQ(back.methods[0].mean, good.mean);
  EXPECT_EQ(back.methods[0].max, good.max);
  EXPECT_TRUE(std::isnan(back.methods[0].vote));
  EXPECT_TRUE(back.methods[0].watertight);
  ASSERT_TRUE(back.methods[0].evidence);
  EXPECT_EQ(back.methods[0].evidence->method, shape::CompletionMethod::kExtrusion);
  EXPECT_EQ(back.methods[0].evidence->support, 0.125);
  EXPECT_TRUE(back.methods[0].evidence->cut_by_image);
  EXPECT_FALSE(back.methods[1].evidence);
  EXPECT_EQ(back.methods[1].problem, failed.problem);
}

TEST(CaseResult, RefusesWhatIsNone) {
  for (const char* text :
       {"", "case: x", "[1, 2", "case: x\ngroup: y\ndata_set: z\norientation: up"}) {
    EXPECT_THROW(read_case_result(text), geometry::InputError) << text;
  }
}

}  // namespace
}  // namespace prehend::eval
