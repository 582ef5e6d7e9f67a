// COLLADA's archives, as they are written.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>

#include "prehend/robot/formats/archive.h"
#include "prehend/robot/formats/file_text.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using ColladaArchives = RobotFiles;

/// What Python says of a script with a file; empty: there is no Python.
std::string python_says(const fs::path& folder, const std::string& script, const fs::path& file) {
  std::ofstream(folder / "script.py") << script;
  const fs::path words = folder / "words";
  const std::string command = "python3 '" + (folder / "script.py").string() + "' '" +
                              file.string() + "' > '" + words.string() + "' 2>&1";
  if (std::system("python3 -c '' 2> /dev/null") != 0) return {};
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::ifstream stream(words);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Files of any length are read again as they were, also none, and those that are not text.
TEST_F(ColladaArchives, GiveFilesBackAsTheyWere) {
  std::string noise;
  unsigned state = 1;
  for (int i = 0; i < 300000; ++i) noise += static_cast<char>((state = 1664525 * state + 7) >> 24);
  const std::vector<std::pair<std::string, std::string>> files{
      {"noise.bin", noise}, {"none.txt", ""}, {"blanks.txt", std::string(2 << 20, ' ')}};
  const fs::path archive = file("a.zip", archive_of(files));
  EXPECT_TRUE(is_archive(head_of_file(archive)));
  for (const auto& [name, text] : files)
    EXPECT_TRUE(file_of_archive(archive, name) == text) << name;
  EXPECT_LT(fs::file_size(archive), noise.size() + (64 << 10));  // blanks are packed
}

TEST_F(ColladaArchives, AreTheSameForTheSameRobot) {
  LossReport unused;
  const RobotDescription robot = read_robot("config/robots/schunk_sdh2.urdf", unused);
  const std::string once = format_named("zae").write(robot, unused);
  EXPECT_TRUE(once == format_named("zae").write(robot, unused));
  EXPECT_EQ(format_for("robot.zae").name(), "zae");
  EXPECT_EQ(format_of(file("robot.zae", once)).name(), "zae");
}

/// By another's zip and another's XML: the date is the first that a zip knows, the manifest names
/// the document, and that is whole.
TEST_F(ColladaArchives, ArePythonsToo) {
  LossReport unused;
  const RobotDescription robot = read_robot("config/robots/schunk_sdh2.urdf", unused);
  const fs::path archive = file("robot.zae", format_named("zae").write(robot, unused));
  const std::string words = python_says(folder_, R"(
import sys, xml.etree.ElementTree, zipfile
archive = zipfile.ZipFile(sys.argv[1])
print("damaged:", archive.testzip())
for one in archive.infolist():
    print(one.filename, one.date_time, one.compress_type == zipfile.ZIP_DEFLATED)
manifest = xml.etree.ElementTree.fromstring(archive.read("manifest.xml"))
print(manifest.tag, manifest.text)
document = xml.etree.ElementTree.fromstring(archive.read(manifest.text.removeprefix("./")))
links = document.iter("{http://www.collada.org/2008/03/COLLADASchema}link")
print("links:", " ".join(sorted(link.get("name") for link in links)))
)",
                                        archive);
  if (words.empty()) GTEST_SKIP() << "no python3";
  std::vector<std::string> names;
  for (const LinkDescription& link : robot.links) names.push_back(link.name);
  std::sort(names.begin(), names.end());
  std::string expected =
      "damaged: None\nmanifest.xml (1980, 1, 1, 0, 0, 0) True\n"
      "robot.dae (1980, 1, 1, 0, 0, 0) True\ndae_root ./robot.dae\nlinks:";
  for (const std::string& name : names) expected += " " + name;
  EXPECT_EQ(words, expected + "\n");
}

TEST_F(ColladaArchives, OfOtherDocumentsAreRefusedInWords) {
  const std::string other = "<robot name='r'><link name='a'/></robot>";
  const std::string manifest = "<dae_root>a.urdf</dae_root>";
  EXPECT_THAT(error_of("a.zae", archive_of({{"manifest.xml", manifest}, {"a.urdf", other}})),
              HasSubstr("a.urdf:1: <robot> is no COLLADA"));
}

}  // namespace
}  // namespace prehend::robot::formats
