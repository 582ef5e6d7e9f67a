#include "drivers/camera/transport/video_devices.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"

namespace prehend::drivers::camera {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class VideoDevices : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-video-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    std::filesystem::permissions(folder_, std::filesystem::perms(0755));
    folders_ = {folder_ / "dev", folder_ / "sys"};
    std::filesystem::create_directories(folders_.devices);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string add(const std::string& file, const std::string& name) const {
    std::ofstream(folders_.devices / file) << "x";
    std::filesystem::create_directories(folders_.names / file);
    std::ofstream(folders_.names / file / "name") << name << "\n";
    return folders_.devices / file;
  }
  std::string error_of(const std::string& file) const {
    try {
      check_video_device(file, folders_);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "no error";
  }

  // Prints what `look` says and ends the process, as somebody who is not root, who may open all.
  [[noreturn]] static void as_nobody(const std::function<std::string()>& look) {
    constexpr uid_t kNobody = 65534;
    if (::geteuid() == 0 && ::setresuid(kNobody, kNobody, kNobody) != 0) ::_exit(2);
    std::cerr << look() << std::endl;
    ::_exit(0);
  }

  std::filesystem::path folder_;
  VideoFolders folders_;
};

TEST_F(VideoDevices, AreListedByNumberWithTheirNames) {
  add("video10", "Wrist");
  add("video2", "Head camera: left");
  add("video", "no number");
  add("videox", "no number");
  add("vbi0", "teletext");
  const auto devices = video_devices(folders_);
  ASSERT_EQ(devices.size(), 2u);
  EXPECT_EQ(devices[0].name, "Head camera: left");
  EXPECT_EQ(devices[1].file, folders_.devices / "video10");
  EXPECT_TRUE(devices[0].may_open);
  EXPECT_TRUE(video_devices({"/nonexistent", "/nonexistent"}).empty());
}

TEST_F(VideoDevices, OneThatIsNotThereIsNamedWithThoseThatAre) {
  EXPECT_THAT(error_of(folders_.devices / "video0"),
              AllOf(HasSubstr("there is no camera"), HasSubstr("video0"),
                    HasSubstr("No camera is plugged in")));
  add("video4", "Head");
  EXPECT_THAT(error_of(folders_.devices / "video0"), HasSubstr("video4 (Head)"));
  EXPECT_THAT(error_of(folders_.devices), HasSubstr("is no camera"));
  EXPECT_THAT(error_of("/dev/null/x"), HasSubstr("/dev/null/x"));
}

TEST_F(VideoDevices, WithoutPermissionTheGroupIsNamed) {
  const std::string file = add("video0", "Head");
  std::filesystem::permissions(file, std::filesystem::perms::none);
  EXPECT_EXIT(as_nobody([&] {
                return (video_devices(folders_).at(0).may_open ? "may open, " : "may not open, ") +
                       error_of(file);
              }),
              ::testing::ExitedWithCode(0),
              AllOf(HasSubstr("may not open"), HasSubstr("no permission to open"),
                    HasSubstr("usermod -aG")));
}

TEST_F(VideoDevices, AFolderWithoutPermissionIsSaidWhateverElseIsThere) {
  // One that is asked what it is, which has errors of its own.
  std::filesystem::permissions(add("video0", "Head"), std::filesystem::perms(0666));
  const std::filesystem::path closed = folder_ / "closed";
  std::filesystem::create_directories(closed);
  std::filesystem::permissions(closed, std::filesystem::perms::none);
  EXPECT_EXIT(as_nobody([&] { return error_of(closed / "video0"); }), ::testing::ExitedWithCode(0),
              HasSubstr("no permission to look for"));
  std::filesystem::permissions(closed, std::filesystem::perms::all);
}

}  // namespace
}  // namespace prehend::drivers::camera
