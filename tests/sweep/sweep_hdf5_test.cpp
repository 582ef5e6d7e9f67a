// prehend sweep --export FILE.h5, read back by HDF5's own library.

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/launch/child_program.h"

#ifdef PREHEND_HAS_HDF5
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <type_traits>

#include <hdf5.h>
#endif

namespace prehend::testing {
namespace {

using ::testing::HasSubstr;

class SweepHdf5 : public ::testing::Test {
 protected:
  std::string run(const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> words{"sweep", description_, "--out", folder_.path(out)};
    words.insert(words.end(), more.begin(), more.end());
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  }
  // ':' does nothing with the parameter, which some argument has to use.
  void describe(const std::string& script) {
    description_ =
        folder_.write("s.yaml", "program: /bin/sh\narguments: [-c, ': {a}; " + script +
                                    "']\ngrid: {a: {from: 1, to: 5}}\nresults: {csv: r.csv}\n");
  }

  ScratchDirectory folder_;
  std::string description_;
  int exit_code_ = -1;
};

#ifdef PREHEND_HAS_HDF5

using Texts = std::vector<std::string>;

// Two rows a case, but case 3 fails: a column of each kind, with and without empty places.
constexpr const char* kTable =
    R"(test {a} = 3 && exit 4; printf "row,figure,force/N,none,note\n1,{a}.5,0.{a},,\"größe, {a}\"\n2,,2,,x\n" > {folder}/r.csv)";

// Fields of lines that end with CR LF; "" in quotes is ".
std::vector<Texts> fields_of(const std::string& csv) {
  std::vector<Texts> lines{{""}};
  bool is_quoted = false;
  for (const char c : csv) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == '"' || (c == '\r' && !is_quoted)) continue;
    if (c == ',' && !is_quoted) {
      lines.back().emplace_back();
    } else if (c == '\n' && !is_quoted) {
      lines.push_back({""});
    } else {
      lines.back().back() += c;
    }
  }
  lines.pop_back();
  return lines;
}

/// A file that HDF5 reads.
class Hdf5File {
 public:
  explicit Hdf5File(const std::string& file)
      : file_(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)),
        group_(H5Gopen2(file_, "/results", H5P_DEFAULT)) {}
  ~Hdf5File() {
    H5Gclose(group_);
    H5Fclose(file_);
  }
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  /// In the order in which they were made.
  Texts names() const {
    H5G_info_t info{};
    H5Gget_info(group_, &info);
    Texts names;
    for (hsize_t i = 0; i < info.nlinks; ++i) {
      std::array<char, 64> name{};
      H5Lget_name_by_idx(group_, ".", H5_INDEX_CRT_ORDER, H5_ITER_INC, i, name.data(), name.size(),
                         H5P_DEFAULT);
      names.emplace_back(name.data());
    }
    return names;
  }
  H5T_class_t kind(const std::string& name) const {
    return with(name, [](hid_t, hid_t type, hsize_t) { return H5Tget_class(type); });
  }
  std::vector<std::int64_t> whole(const std::string& name) const {
    return with(name, [](hid_t set, hid_t type, hsize_t size) {
      EXPECT_TRUE(H5Tequal(type, H5T_STD_I64LE) > 0);
      return read<std::int64_t>(set, H5T_NATIVE_INT64, size);
    });
  }
  std::vector<double> numbers(const std::string& name) const {
    return with(name, [](hid_t set, hid_t type, hsize_t size) {
      EXPECT_TRUE(H5Tequal(type, H5T_IEEE_F64LE) > 0);
      return read<double>(set, H5T_NATIVE_DOUBLE, size);
    });
  }
  Texts texts(const std::string& name) const {
    return with(name, [](hid_t set, hid_t type, hsize_t size) {
      EXPECT_TRUE(H5Tis_variable_str(type) > 0);
      EXPECT_EQ(H5Tget_cset(type), H5T_CSET_UTF8);
      Texts texts;
      for (char* one : read<char*>(set, type, size)) {
        texts.emplace_back(one);
        H5free_memory(one);
      }
      return texts;
    });
  }
  std::int64_t failed() const {
    const hid_t attribute = H5Aopen(group_, "failed", H5P_DEFAULT);
    std::int64_t value = -1;
    H5Aread(attribute, H5T_NATIVE_INT64, &value);
    H5Aclose(attribute);
    return value;
  }
  std::string description() const {
    const hid_t attribute = H5Aopen(group_, "description", H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    char* read = nullptr;
    H5Aread(attribute, type, &read);
    const std::string text = read ? read : "";
    H5free_memory(read);
    H5Tclose(type);
    H5Aclose(attribute);
    return text;
  }

 private:
  template <class Value>
  static std::vector<Value> read(hid_t set, hid_t type, hsize_t size) {
    std::vector<Value> values(size);
    EXPECT_GE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
    return values;
  }
  template <class Use>
  std::invoke_result_t<Use, hid_t, hid_t, hsize_t> with(const std::string& name, Use use) const {
    const hid_t set = H5Dopen2(group_, name.c_str(), H5P_DEFAULT);
    EXPECT_GE(set, 0) << name;
    const hid_t type = H5Dget_type(set), space = H5Dget_space(set);
    EXPECT_EQ(H5Sget_simple_extent_ndims(space), 1);
    hsize_t size = 0;
    H5Sget_simple_extent_dims(space, &size, nullptr);
    auto result = use(set, type, size);
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(set);
    return result;
  }

  hid_t file_, group_;
};

TEST_F(SweepHdf5, HasTheValuesOfTheCsvInTheKindsOfItsColumns) {
  describe(kTable);
  run("w", {"--export", folder_.path("w.csv")});
  EXPECT_THAT(run("w", {"--status", "--export", folder_.path("w.h5")}), HasSubstr("w.h5: 9 rows"));
  auto lines = fields_of(text_of_file(folder_.path("w.csv")));
  ASSERT_EQ(lines.size(), 10U);
  const Texts header = lines.front();
  EXPECT_THAT(header, ::testing::ElementsAre("case", "a", "state", "problem", "row", "figure",
                                             "force/N", "none", "note"));
  lines.erase(lines.begin());

  const Hdf5File file(folder_.path("w.h5"));
  EXPECT_EQ(file.description(), "s.yaml");
  EXPECT_EQ(file.failed(), 1);
  const Texts names = file.names();
  EXPECT_THAT(names, ::testing::ElementsAre("case", "a", "state", "problem", "row", "figure",
                                            "force:N", "none", "note"));
  const std::vector<H5T_class_t> kinds{H5T_STRING, H5T_INTEGER, H5T_STRING, H5T_STRING, H5T_FLOAT,
                                       H5T_FLOAT,  H5T_FLOAT,   H5T_STRING, H5T_STRING};
  for (std::size_t column = 0; column < header.size(); ++column) {
    SCOPED_TRACE(header[column]);
    ASSERT_EQ(file.kind(names[column]), kinds[column]);
    const auto whole = kinds[column] == H5T_INTEGER ? file.whole(names[column])
                                                    : std::vector<std::int64_t>(lines.size());
    const auto numbers = kinds[column] == H5T_FLOAT ? file.numbers(names[column])
                                                    : std::vector<double>(lines.size());
    const auto texts =
        kinds[column] == H5T_STRING ? file.texts(names[column]) : Texts(lines.size());
    ASSERT_EQ(whole.size() + numbers.size() + texts.size(), 3 * lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::string& said = lines[i].at(column);
      if (kinds[column] == H5T_STRING) {
        EXPECT_EQ(texts[i], said);
      } else if (kinds[column] == H5T_INTEGER) {
        EXPECT_EQ(whole[i], std::stoll(said));
      } else if (said.empty()) {
        EXPECT_TRUE(std::isnan(numbers[i])) << i;
      } else {
        EXPECT_EQ(numbers[i], std::stod(said));
      }
    }
  }
  EXPECT_EQ(file.texts("note").front(), "größe, 1");
}

TEST_F(SweepHdf5, IsTheSameByteByByteWhoeverRanWhat) {
  describe(kTable);
  run("one", {"--workers", "1", "--export", folder_.path("one.h5")});
  run("many", {"--workers", "5", "--export", folder_.path("many.h5")});
  run("one", {"--status", "--export", folder_.path("again.h5")});
  const std::string one = text_of_file(folder_.path("one.h5"));
  ASSERT_GT(one.size(), 1000U);
  EXPECT_TRUE(text_of_file(folder_.path("many.h5")) == one);
  EXPECT_TRUE(text_of_file(folder_.path("again.h5")) == one);
  EXPECT_FALSE(std::filesystem::exists(folder_.path("one.h5.part")));
}

TEST_F(SweepHdf5, ManyRowsStayInTheirOrder) {
  describe("(echo row,name; seq 1 2500 | sed \"s/.*/&,n&/\") > {folder}/r.csv");
  EXPECT_THAT(run("w", {"--export", folder_.path("w.h5")}), HasSubstr("12500 rows"));
  EXPECT_EQ(exit_code_, 0);
  const Hdf5File file(folder_.path("w.h5"));
  const auto rows = file.whole("row"), cases = file.whole("a");
  const auto names = file.texts("name");
  ASSERT_EQ(rows.size(), 12500U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i], static_cast<std::int64_t>(i % 2500 + 1));
    ASSERT_EQ(cases[i], static_cast<std::int64_t>(i / 2500 + 1));
    ASSERT_EQ(names[i], "n" + std::to_string(i % 2500 + 1));
  }
  EXPECT_EQ(file.failed(), 0);
}

TEST_F(SweepHdf5, ColumnsOfOneNameAndFoldersThatAreNoneAreRefused) {
  describe("printf \"f/N,f:N\\n1,2\\n\" > {folder}/r.csv");
  EXPECT_THAT(run("w", {"--export", folder_.path("w.h5")}), HasSubstr("'f:N'"));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_.path("w.h5")));
  const std::string below_a_file = folder_.write("file", "") + "/w.h5";
  describe("printf \"v\\n1\\n\" > {folder}/r.csv");
  EXPECT_THAT(run("v", {"--export", below_a_file}), HasSubstr("cannot be written"));
  EXPECT_EQ(exit_code_, 1);
}

#else

TEST_F(SweepHdf5, IsRefusedWithTheNameOfThePackageBeforeAnythingRuns) {
  describe("echo v > {folder}/r.csv");
  EXPECT_THAT(run("w", {"--export", folder_.path("w.h5")}), HasSubstr("libhdf5-dev"));
  EXPECT_EQ(exit_code_, 1);
}

#endif

}  // namespace
}  // namespace prehend::testing
