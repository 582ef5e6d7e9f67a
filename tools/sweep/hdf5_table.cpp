#include "tools/sweep/hdf5_table.h"

#include "prehend/text/input_error.h"

#ifdef PREHEND_HAS_HDF5

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <hdf5.h>

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using sweep::ColumnKind;
using text::InputError;

constexpr hsize_t kBlock = 4096;  // rows that are written at once

void check(herr_t status) {
  if (status < 0) throw InputError("HDF5 cannot write the table", "Check the space there");
}

// What HDF5 gave, closed at the end. A number below 0 is an error of it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*end)(hid_t)) : id_(id), close_(end) { check(id < 0 ? -1 : 0); }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

  /// What is still to be written is written then; the destructor could not say that it was not.
  void close() { check(close_(std::exchange(id_, -1))); }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  check(H5Tset_size(type, H5T_VARIABLE));
  check(H5Tset_cset(type, H5T_CSET_UTF8));
  return type;
}

void add_attribute(hid_t owner, const char* name, hid_t type, const void* value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle made(H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(H5Awrite(made, type, value));
}

// Names keep their order, and are UTF-8.
Handle make_group(hid_t file) {
  const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  check(H5Pset_obj_track_times(creation, false));
  check(H5Pset_link_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED));
  return {H5Gcreate2(file, "results", H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose};
}

template <class Number>
std::vector<Number> numbers(const std::vector<std::string>& texts, Number none) {
  std::vector<Number> read(texts.size(), none);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::from_chars(texts[i].data(), texts[i].data() + texts[i].size(), read[i]);
  }
  return read;
}

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> made;
  for (const std::string& text : texts) made.push_back(text.c_str());
  return made;
}

// '/' would make groups of a name, and "." is the group itself.
std::string data_set_name(std::string name) {
  std::replace(name.begin(), name.end(), '/', ':');
  return name.empty() || name == "." ? ":" + name : name;
}

class ColumnWriter {
 public:
  ColumnWriter(hid_t group, const sweep::Column& column, hsize_t rows)
      : name_(column.name),
        kind_(column.kind),
        type_(kind_ == ColumnKind::kText    ? text_type()
              : kind_ == ColumnKind::kWhole ? Handle(H5Tcopy(H5T_STD_I64LE), H5Tclose)
                                            : Handle(H5Tcopy(H5T_IEEE_F64LE), H5Tclose)),
        space_(H5Screate_simple(1, &rows, nullptr), H5Sclose),
        set_(make(group)) {}

  void append(const std::string& value) {
    if (value.find('\0') != std::string::npos) {
      throw InputError("A text of the column '" + name_ + "' has a zero character",
                       "Export CSV, or let the program leave it out");
    }
    values_.push_back(value);
    if (values_.size() == kBlock) flush();
  }

  void flush() {
    if (values_.empty()) return;
    const hsize_t count = values_.size();
    check(H5Sselect_hyperslab(space_, H5S_SELECT_SET, &written_, nullptr, &count, nullptr));
    const Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    switch (kind_) {
      case ColumnKind::kWhole:
        write(memory, H5T_NATIVE_INT64, numbers<std::int64_t>(values_, 0));
        break;
      case ColumnKind::kNumber:
        write(memory, H5T_NATIVE_DOUBLE,
              numbers(values_, std::numeric_limits<double>::quiet_NaN()));
        break;
      case ColumnKind::kText:
        write(memory, type_, pointers(values_));
        break;
    }
    written_ += count;
    values_.clear();
  }

 private:
  Handle make(hid_t group) const {
    const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    check(H5Pset_obj_track_times(creation, false));
    const Handle link(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    check(H5Pset_char_encoding(link, H5T_CSET_UTF8));
    return {
        H5Dcreate2(group, data_set_name(name_).c_str(), type_, space_, link, creation, H5P_DEFAULT),
        H5Dclose};
  }

  template <class Value>
  void write(hid_t memory, hid_t type, const std::vector<Value>& values) {
    check(H5Dwrite(set_, type, memory, space_, H5P_DEFAULT, values.data()));
  }

  std::string name_;
  ColumnKind kind_;
  Handle type_, space_, set_;
  hsize_t written_ = 0;
  std::vector<std::string> values_;
};

void check_names(const std::vector<sweep::Column>& columns) {
  std::set<std::string> names;
  for (const sweep::Column& column : columns) {
    if (!names.insert(data_set_name(column.name)).second) {
      throw InputError("The column '" + column.name + "' and another would both be the data set '" +
                           data_set_name(column.name) + "'",
                       "Rename one in the results, or export CSV");
    }
  }
}

void write_results(hid_t group, const sweep::ResultTable& table, const std::string& description) {
  const char* named = description.c_str();
  const std::int64_t failed = table.failed();
  add_attribute(group, "description", text_type(), &named);
  add_attribute(group, "failed", H5T_NATIVE_INT64, &failed);
  std::vector<ColumnWriter> writers;
  for (const sweep::Column& column : table.columns()) {
    writers.emplace_back(group, column, static_cast<hsize_t>(table.rows()));
  }
  table.for_each_row([&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) writers[i].append(row[i]);
  });
  for (ColumnWriter& writer : writers) writer.flush();
}

}  // namespace

void check_hdf5() {}

void write_hdf5(const sweep::ResultTable& table, const std::string& description,
                const fs::path& file) {
  check_names(table.columns());
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // what fails is said by exceptions
  sweep::write_whole(file, [&](const fs::path& part) {
    const hid_t opened = H5Fcreate(part.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    if (opened < 0) {
      throw InputError("'" + part.string() + "' cannot be written",
                       "Check its folder and the space there");
    }
    Handle made(opened, H5Fclose);
    write_results(make_group(made), table, description);
    check(H5Fflush(made, H5F_SCOPE_LOCAL));
    made.close();
  });
}

}  // namespace prehend::tools

#else

namespace prehend::tools {

void check_hdf5() {
  throw text::InputError("This prehend was built without HDF5",
                         "Install libhdf5-dev and build it again, or export CSV");
}

void write_hdf5(const sweep::ResultTable&, const std::string&, const std::filesystem::path&) {
  check_hdf5();
}

}  // namespace prehend::tools

#endif
