#include "prehend/viewing/page_files.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::viewing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class PageFiles : public ::testing::Test {
 protected:
  PageFiles() {
    std::string name = (fs::temp_directory_path() / "page_files_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for the test");
    root_ = name;
    fs::create_directories(root_ / "dist/sub");
    write("secret.txt", "secret");
    write("dist/index.html", "<p>");
    write("dist/viewer.js", "1");
    write("dist/sub/a b.css", "2");
    write("dist/.env", "secret");
    fs::create_symlink(root_ / "secret.txt", root_ / "dist/link.txt");
  }
  ~PageFiles() override { fs::remove_all(root_); }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(root_ / name) << text;
  }
  PageFile get(const std::string& target) const { return page_file(root_ / "dist", target); }

  fs::path root_;
};

TEST_F(PageFiles, AreServedWithTheirTypes) {
  EXPECT_EQ(get("/").content, "<p>");
  EXPECT_EQ(get("/?token=x").content, "<p>");
  EXPECT_THAT(get("/").type, HasSubstr("text/html"));
  EXPECT_THAT(get("/viewer.js").type, HasSubstr("text/javascript"));
  EXPECT_EQ(get("/sub/a%20b.css").content, "2");
}

TEST_F(PageFiles, WhatLiesOutsideIsNotThere) {
  for (const char* target :
       {"/../secret.txt", "/%2e%2e/secret.txt", "/sub/../../secret.txt", "/..%2fsecret.txt",
        "/..\\secret.txt", "/.env", "/link.txt", "/sub", "/nothing.js", "//../secret.txt"}) {
    const PageFile answer = get(target);
    EXPECT_EQ(answer.status, 404) << target;
    EXPECT_THAT(answer.content, Not(HasSubstr("secret\n"))) << target;
    EXPECT_NE(answer.content, "secret") << target;
  }
  EXPECT_EQ(get("/%").status, 400);
  EXPECT_EQ(get("/a%00.js").status, 400);
  EXPECT_EQ(get("viewer.js").status, 400);
  EXPECT_EQ(get("").status, 400);
}

TEST_F(PageFiles, APageThatWasNotBuiltIsToldSo) {
  const PageFile answer = page_file(root_ / "nothing", "/");
  EXPECT_EQ(answer.status, 404);
  EXPECT_THAT(answer.content, HasSubstr("page is not there"));
}

}  // namespace
}  // namespace prehend::viewing
