#include "prehend/touch/touch_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include <unistd.h>

#include "prehend/geometry/errors.h"
#include "tests/touch/pressed.h"

namespace prehend::touch {
namespace {

using testing::ball;
using testing::fine_pad;
using ::testing::HasSubstr;
using testing::pressed;

class Memory : public ::testing::Test {
 protected:
  Memory()
      : file_(std::filesystem::temp_directory_path() /
              ("prehend_touch_memory_" + std::to_string(getpid()) + ".yaml")) {}
  ~Memory() override { std::filesystem::remove(file_); }

  // A ball between two pads, gripped anywhere.
  RememberedPress grasp(double radius, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const double x = 0.004 * unit(random), y = 0.012 * unit(random);
    const auto counts = pressed(pad_, ball(radius, 0.0012 + 1e-4 * unit(random), x, y));
    return remembered(Eigen::VectorXd::Constant(1, 2 * radius - 0.0024 + 1e-4 * unit(random)),
                      {{&pad_, counts}, {&pad_, counts}});
  }
  TouchMemory taught(RecogniseBy by = RecogniseBy::kGrasp, unsigned count = 24) const {
    TouchMemory memory(by);
    for (unsigned k = 0; k < count; ++k) {
      memory.teach("egg's twin", grasp(0.022, k));
      memory.teach("ball", grasp(0.03, 50 + k));
    }
    return memory;
  }
  std::string text() const {
    std::ifstream file(file_);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const std::string& words) const { std::ofstream(file_) << words; }

  FeltPad pad_ = fine_pad();
  std::filesystem::path file_;
};

TEST_F(Memory, KnowsBallsByTheirSizeAndRefusesOthers) {
  TouchMemory memory = taught();
  for (unsigned k = 0; k < 10; ++k) {
    EXPECT_EQ(memory.ask({grasp(0.022, 100 + k), grasp(0.022, 200 + k)}).name, "egg's twin");
    EXPECT_EQ(memory.ask({grasp(0.03, 100 + k), grasp(0.03, 200 + k)}).name, "ball");
  }
  const Recognised other = memory.ask({grasp(0.012, 1)});
  EXPECT_TRUE(other.name.empty());
  EXPECT_THAT(other.reason, HasSubstr("it is likest"));
  EXPECT_TRUE(memory.forget("ball"));
  EXPECT_FALSE(memory.forget("ball"));
  EXPECT_TRUE(memory.ask({grasp(0.03, 7)}).name.empty());
}

TEST_F(Memory, SavedAndLoadedAnswersAlike) {
  for (const RecogniseBy by : {RecogniseBy::kGrasp, RecogniseBy::kImprint}) {
    TouchMemory memory = taught(by, 5);
    memory.save(file_);
    TouchMemory loaded = TouchMemory::load(file_, by);
    ASSERT_EQ(loaded.things().size(), 2u);
    EXPECT_EQ(loaded.things().at("egg's twin").size(), 5u);
    const auto question = grasp(0.03, 300);
    const Recognised a = memory.ask({question}), b = loaded.ask({question});
    EXPECT_EQ(a.name, b.name);
    // Imprints are kept in ten steps.
    EXPECT_NEAR(a.candidates[0].misfit, b.candidates[0].misfit, 0.5);
  }
  TouchMemory(RecogniseBy::kGrasp).save(file_);
  EXPECT_TRUE(TouchMemory::load(file_, RecogniseBy::kGrasp).things().empty());
}

TEST_F(Memory, DamagedFilesAreRefusedWithPlaceAndMend) {
  taught().save(file_);
  const std::string whole = text();
  const auto refused = [&](const std::string& from, const std::string& to) -> std::string {
    std::string damaged = whole;
    damaged.replace(damaged.find(from), from.size(), to);
    write(damaged);
    try {
      TouchMemory::load(file_, RecogniseBy::kGrasp);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "it was not refused";
  };
  EXPECT_THAT(refused("version: 1", "version: 7"), HasSubstr("This program reads 1"));
  EXPECT_THAT(refused("layout: 0", "layout: 5"), HasSubstr("none of the file's layouts"));
  EXPECT_THAT(refused("features: '", "features: 'nan "), HasSubstr("no row of numbers"));
  EXPECT_THAT(refused("pressed: '", "pressed: 'x"), HasSubstr("digit"));
  EXPECT_THAT(refused("pressed: '", "pressed: '9"), HasSubstr("not as long as its layout"));
  EXPECT_THAT(refused("features: '", "features: '1 "), HasSubstr("another hand"));
  EXPECT_THAT(refused("presses:", "pressings:"), HasSubstr("presses"));
  EXPECT_THROW(TouchMemory::load("no/such/file.yaml", RecogniseBy::kGrasp), geometry::InputError);
  EXPECT_THROW(taught().save("no/such/folder/file.yaml"), geometry::InputError);
}

TEST_F(Memory, RefusesWhatItCannotRemember) {
  TouchMemory memory = taught();
  const RememberedPress nothing = remembered(Eigen::VectorXd::Constant(1, 0.05), {});
  EXPECT_THROW(memory.teach("air", nothing), std::invalid_argument);
  EXPECT_THROW(memory.ask({nothing}), std::invalid_argument);
  EXPECT_THROW(memory.ask({}), std::invalid_argument);
  EXPECT_THROW(memory.teach("", grasp(0.03, 1)), std::invalid_argument);
  EXPECT_THROW(memory.teach("two\nlines", grasp(0.03, 1)), std::invalid_argument);
  const auto counts = pressed(pad_, ball(0.03, 0.001, 0, 0));
  const RememberedPress of_hand = remembered(Eigen::VectorXd::Constant(7, 0.1), {{&pad_, counts}});
  EXPECT_THROW(memory.teach("by fingers", of_hand), std::invalid_argument);
  EXPECT_EQ(memory.things().size(), 2u);
}

}  // namespace
}  // namespace prehend::touch
