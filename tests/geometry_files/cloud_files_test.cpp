#include "prehend/geometry/cloud_files.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/geometry_files/scratch_folder.h"

namespace prehend::geometry {
namespace {

using ::testing::HasSubstr;

class CloudFiles : public ::testing::Test {
 protected:
  std::string error_of(const std::string& name, const std::string& bytes) {
    return error_of(scratch_.write(name, bytes));
  }
  std::string error_of(const std::filesystem::path& path) {
    try {
      read_cloud_file(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }
  testing::ScratchFolder scratch_;
};

PointCloud colored_cloud(bool organized) {
  PointCloud cloud;
  for (int i = 0; i < 12; ++i) {
    cloud.points.emplace_back(0.1F * static_cast<float>(i), -0.2F, 1.0F + static_cast<float>(i));
    cloud.colors.push_back({static_cast<std::uint8_t>(20 * i), 2, 255});
  }
  cloud.points[3].setConstant(std::numeric_limits<float>::quiet_NaN());
  if (organized) {
    cloud.width = 4;
    cloud.height = 3;
  }
  return cloud;
}

void expect_same(const PointCloud& a, const PointCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!is_finite(b.points[i])) {
      EXPECT_FALSE(is_finite(a.points[i]));
      continue;
    }
    EXPECT_EQ(a.points[i], b.points[i]);
  }
  EXPECT_EQ(a.colors, b.colors);
}

TEST_F(CloudFiles, PcdRoundTrip) {
  const RigidTransform viewpoint = make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY())), {1, 2, 3});
  const PointCloud cloud = colored_cloud(true);
  write_cloud_file(scratch_.path() / "a.pcd", cloud, viewpoint);
  const CloudFile file = read_cloud_file(scratch_.path() / "a.pcd");
  expect_same(file.cloud, cloud);
  EXPECT_EQ(file.cloud.width, 4);
  EXPECT_EQ(file.cloud.height, 3);
  ASSERT_TRUE(file.viewpoint);
  EXPECT_TRUE(file.viewpoint->isApprox(viewpoint, 1e-5));
  EXPECT_FALSE(file.has_labels);
}

TEST_F(CloudFiles, PlyRoundTrip) {
  PointCloud cloud = colored_cloud(false);
  cloud.points[3] = Eigen::Vector3f(5, 6, 7);
  cloud.normals.assign(cloud.size(), Eigen::Vector3f::UnitZ());
  write_cloud_file(scratch_.path() / "a.ply", cloud);
  const CloudFile file = read_cloud_file(scratch_.path() / "a.ply");
  expect_same(file.cloud, cloud);
  ASSERT_EQ(file.cloud.normals.size(), cloud.size());
  EXPECT_EQ(file.cloud.normals[5], Eigen::Vector3f::UnitZ());
}

std::string pcd(const std::string& fields, const std::string& sizes, const std::string& types,
                const std::string& width, const std::string& points, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " + types +
         "\nWIDTH " + width + "\nHEIGHT 1\nVIEWPOINT 0 0 0 0 1 0 0\nPOINTS " + points + "\nDATA " +
         data;
}

std::string xyz_pcd(const std::string& points, const std::string& data) {
  return pcd("x y z", "4 4 4", "F F F", points, points, data);
}

TEST_F(CloudFiles, AsciiPcdWithPackedColourAndLabels) {
  const std::string file_text = pcd("label x y z rgba", "4 4 4 4 4", "U F F F U", "2", "2",
                                    "ascii\n21 1 2 3 4278255360\n0 nan nan nan 4294901760\n");
  const CloudFile file = read_cloud_file(scratch_.write("a.pcd", file_text));
  ASSERT_EQ(file.cloud.size(), 2U);
  EXPECT_EQ(file.cloud.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_FALSE(is_finite(file.cloud.points[1]));
  EXPECT_EQ(file.cloud.colors[0], (Rgb{0, 255, 0}));
  EXPECT_EQ(file.cloud.colors[1], (Rgb{255, 0, 0}));
  EXPECT_TRUE(file.has_labels);
  EXPECT_EQ(file.labels, (std::vector<std::uint32_t>{21, 0}));
  EXPECT_FALSE(file.cloud.organized());
  ASSERT_TRUE(file.viewpoint);
  EXPECT_TRUE(file.viewpoint->linear().isApprox(
      Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), 1e-12));
}

TEST_F(CloudFiles, FloatColourAndDoubleCoordinates) {
  const std::uint32_t packed = 0x00102030;
  std::string record(28, '\0');
  const double p[3] = {1.5, -2.5, 3.25};
  std::memcpy(record.data(), p, 24);
  std::memcpy(record.data() + 24, &packed, 4);
  const CloudFile file = read_cloud_file(scratch_.write(
      "a.pcd", pcd("x y z rgb", "8 8 8 4", "F F F F", "1", "1", "binary\n" + record)));
  EXPECT_EQ(file.cloud.points[0], Eigen::Vector3f(1.5F, -2.5F, 3.25F));
  EXPECT_EQ(file.cloud.colors[0], (Rgb{0x10, 0x20, 0x30}));
}

TEST_F(CloudFiles, AsciiPly) {
  const std::string text =
      "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 2\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nend_header\n0 1 2 255 0 9\n3 4 5 0 255 8\n";
  const CloudFile file = read_cloud_file(scratch_.write("a.ply", text));
  ASSERT_EQ(file.cloud.size(), 2U);
  EXPECT_EQ(file.cloud.points[1], Eigen::Vector3f(3, 4, 5));
  EXPECT_EQ(file.cloud.colors[0], (Rgb{255, 0, 9}));
  EXPECT_FALSE(file.viewpoint);
}

TEST_F(CloudFiles, MissingForeignAndEmptyFiles) {
  EXPECT_THAT(error_of(scratch_.path() / "none.pcd"),
              AllOf(HasSubstr("none.pcd"), HasSubstr("does not exist")));
  EXPECT_THAT(error_of(scratch_.path()), HasSubstr("not a file"));
  EXPECT_THAT(error_of("empty.pcd", ""), HasSubstr("empty"));
  EXPECT_THAT(error_of("empty.ply", ""), HasSubstr("empty"));
  EXPECT_THAT(error_of("png.pcd", "\x89PNG\r\n\x1a\n0123456789"), HasSubstr("not a PCD"));
  EXPECT_THAT(error_of("png.ply", "\x89PNG\r\n\x1a\n0123456789"), HasSubstr("not a PLY"));
  EXPECT_THAT(error_of("long.pcd", std::string(100000, 'a')), HasSubstr("header"));
  EXPECT_THAT(error_of("cloud.txt", "1 2 3"), HasSubstr(".pcd"));
}

TEST_F(CloudFiles, HeadersThatPromiseTooMuchAllocateNothing) {
  EXPECT_THAT(error_of("a.pcd", xyz_pcd("1000000000000", "ascii\n1 2 3\n")), HasSubstr("promises"));
  EXPECT_THAT(error_of("a.pcd", xyz_pcd("1000000000000", "binary\n123456789012")),
              HasSubstr("promises"));
  EXPECT_THAT(error_of("a.pcd", xyz_pcd("1000",
                                        "binary_compressed\n\x04\x01\x01\x01"
                                        "abcdefgh")),
              HasSubstr("a.pcd"));
  EXPECT_THAT(error_of("a.pcd", xyz_pcd("99999999999999999999999999", "ascii\n1 2 3\n")),
              HasSubstr("POINTS"));
  EXPECT_THAT(error_of("a.pcd", xyz_pcd("-5", "ascii\n1 2 3\n")), HasSubstr("whole number"));
  EXPECT_THAT(error_of("a.ply",
                       "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
                       "property float x\nproperty float y\nproperty float z\n"
                       "end_header\n123456789012"),
              HasSubstr("promises"));
  EXPECT_THAT(error_of("a.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                       "property float y\nproperty float z\nelement face 2000000000\n"
                       "property list uchar int vertex_indices\nend_header\n1 2 3\n"),
              HasSubstr("promises"));
}

TEST_F(CloudFiles, ContradictoryHeaders) {
  const std::string body = "ascii\n1 2 3\n";
  EXPECT_THAT(error_of("a.pcd", pcd("x y z", "4 4 4", "F F F", "2", "1", body)),
              HasSubstr("WIDTH"));
  EXPECT_THAT(error_of("a.pcd", pcd("x y z", "4 4", "F F F", "1", "1", body)), HasSubstr("SIZE"));
  EXPECT_THAT(error_of("a.pcd", pcd("x y z", "4 4 3", "F F F", "1", "1", body)),
              HasSubstr("impossible"));
  EXPECT_THAT(error_of("a.pcd", pcd("x y w", "4 4 4", "F F F", "1", "1", body)), HasSubstr("'z'"));
  EXPECT_THAT(error_of("a.pcd", pcd("x y z", "4 4 4", "F F I", "1", "1", body)),
              HasSubstr("floating"));
  EXPECT_THAT(error_of("a.pcd", xyz_pcd("0", "ascii\n")), HasSubstr("no points"));
  EXPECT_THAT(error_of("a.pcd", xyz_pcd("1", "zipped\n1 2 3\n")), HasSubstr("zipped"));
  EXPECT_THAT(error_of("a.pcd", "VERSION 0.7\nFIELDS x y z\n"), HasSubstr("DATA"));
  EXPECT_THAT(error_of("a.ply",
                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                       "property float y\nend_header\n1 2\n"),
              HasSubstr("'z'"));
  EXPECT_THAT(error_of("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty floot x\n"),
              HasSubstr("floot"));
}

// Every prefix of a good file either reads whole or is an InputError.
TEST_F(CloudFiles, EveryTruncationIsAnError) {
  const PointCloud cloud = colored_cloud(false);
  for (const char* name : {"whole.pcd", "whole.ply"}) {
    write_cloud_file(scratch_.path() / name, cloud);
    std::string bytes = testing::ScratchFolder::read(scratch_.path() / name);
    // PCL pads a binary PCD to a whole page.
    const std::size_t data = bytes.find("DATA binary\n");
    if (data != std::string::npos) bytes.resize(data + 12 + 16 * cloud.size());
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const std::string cut_name = std::string("cut") + (name + 5);
      EXPECT_NE(error_of(cut_name, bytes.substr(0, size)), "no error") << name << " " << size;
    }
  }
  const std::string ascii = xyz_pcd("3", "ascii\n1 2 3\n4 5 6\n7 8 9\n");
  for (std::size_t size = 0; size + 2 < ascii.size(); ++size) {
    EXPECT_NE(error_of("cut.pcd", ascii.substr(0, size)), "no error") << size;
  }
}

TEST_F(CloudFiles, AsciiBodyOfWords) {
  EXPECT_NE(error_of("a.pcd", xyz_pcd("2", "ascii\nfoo bar baz\nqux quux corge\n")), "no error");
  EXPECT_NE(error_of("a.pcd", xyz_pcd("2", "ascii\n1 2\n3 4 5 6 7 8 9\n")), "no error");
}

TEST_F(CloudFiles, WritingWhereItCannot) {
  const PointCloud cloud = colored_cloud(false);
  EXPECT_THROW(write_cloud_file(scratch_.path() / "none" / "a.pcd", cloud), InputError);
  EXPECT_THROW(write_cloud_file(scratch_.path() / "none" / "a.ply", cloud), InputError);
  EXPECT_THROW(write_cloud_file(scratch_.path() / "a.xyz", cloud), InputError);
  EXPECT_THROW(write_cloud_file(scratch_.path() / "a.pcd", {}), InputError);
}

}  // namespace
}  // namespace prehend::geometry
