#include "prehend/perception/image_files.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

TEST(ImageFiles, RoundTripAndErrors) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("prehend_image_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  geometry::ColorImage image(37, 21);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 3), 200};
  }
  write_color_image(folder / "a.png", image);
  const geometry::ColorImage again = read_color_image(folder / "a.png");
  EXPECT_EQ(again.width, 37);
  EXPECT_EQ(again.data, image.data);

  EXPECT_THROW(read_color_image(folder / "none.png"), geometry::InputError);
  EXPECT_THROW(read_color_image(folder), geometry::InputError);
  std::ofstream(folder / "text.png") << "not an image";
  EXPECT_THROW(read_color_image(folder / "text.png"), geometry::InputError);
  std::ofstream(folder / "empty.png").close();
  EXPECT_THROW(read_color_image(folder / "empty.png"), geometry::InputError);
  EXPECT_THROW(write_color_image(folder / "none" / "a.png", image), geometry::InputError);
  EXPECT_THROW(write_color_image(folder / "a.nothing", image), geometry::InputError);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace prehend::perception
