#include "tools/sweep/hdf5_table.h"

#include "prehend/text/input_error.h"

#ifdef PREHEND_HAS_HDF5

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <hdf5.h>

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using sweep::ColumnKind;

constexpr hsize_t kBlock = 4096;  // rows that are written at once

// What HDF5 gave, closed at the end. A number below 0 is an error of it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
    if (id < 0) throw text::InputError("HDF5 refuses to make a part of the table", "Export CSV");
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void check(herr_t status) {
  if (status < 0) throw text::InputError("HDF5 cannot write the table", "Check the space there");
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  check(H5Tset_size(type, H5T_VARIABLE));
  check(H5Tset_cset(type, H5T_CSET_UTF8));
  return type;
}

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> made;
  for (const std::string& text : texts) made.push_back(text.c_str());
  return made;
}

void add_attribute(hid_t owner, const char* name, const std::vector<std::string>& texts) {
  const Handle type = text_type();
  const hsize_t size = texts.size();
  const Handle space(
      texts.size() == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose);
  const Handle made(H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(H5Awrite(made, type, pointers(texts).data()));
}

template <class Number>
std::vector<Number> numbers(const std::vector<std::string>& texts, Number none) {
  std::vector<Number> read(texts.size(), none);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::from_chars(texts[i].data(), texts[i].data() + texts[i].size(), read[i]);
  }
  return read;
}

// '/' would make groups of a name.
std::string dataset_name(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name.empty() || name == "." ? "_" : name;
}

class ColumnWriter {
 public:
  ColumnWriter(hid_t file, const sweep::Column& column, hsize_t rows)
      : kind_(column.kind),
        type_(kind_ == ColumnKind::kText    ? text_type()
              : kind_ == ColumnKind::kWhole ? Handle(H5Tcopy(H5T_NATIVE_INT64), H5Tclose)
                                            : Handle(H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose)),
        space_(H5Screate_simple(1, &rows, nullptr), H5Sclose),
        set_(make(file, column, type_, space_)) {}

  void append(std::string value) {
    values_.push_back(std::move(value));
    if (values_.size() == kBlock) flush();
  }

  void flush() {
    if (values_.empty()) return;
    const hsize_t count = values_.size();
    check(H5Sselect_hyperslab(space_, H5S_SELECT_SET, &written_, nullptr, &count, nullptr));
    const Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    switch (kind_) {
      case ColumnKind::kWhole:
        write(memory, numbers<std::int64_t>(values_, 0));
        break;
      case ColumnKind::kNumber:
        write(memory, numbers(values_, std::numeric_limits<double>::quiet_NaN()));
        break;
      case ColumnKind::kText:
        write(memory, pointers(values_));
        break;
    }
    written_ += count;
    values_.clear();
  }

 private:
  static Handle make(hid_t file, const sweep::Column& column, hid_t type, hid_t space) {
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    check(H5Pset_obj_track_times(properties, false));
    return {H5Dcreate2(file, dataset_name(column.name).c_str(), type, space, H5P_DEFAULT,
                       properties, H5P_DEFAULT),
            H5Dclose};
  }

  template <class Value>
  void write(hid_t memory, const std::vector<Value>& values) {
    check(H5Dwrite(set_, type_, memory, space_, H5P_DEFAULT, values.data()));
  }

  ColumnKind kind_;
  Handle type_, space_, set_;
  hsize_t written_ = 0;
  std::vector<std::string> values_;
};

}  // namespace

void write_hdf5(const sweep::ResultTable& table, const sweep::Description& description,
                const fs::path& file) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // what fails is said by exceptions
  sweep::write_whole(file, [&](const fs::path& part) {
    const hid_t opened = H5Fcreate(part.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    if (opened < 0) {
      throw text::InputError("'" + part.string() + "' cannot be written",
                             "Check its folder and the space there");
    }
    const Handle made(opened, H5Fclose);
    std::vector<std::string> names;
    std::vector<ColumnWriter> writers;
    for (const sweep::Column& column : table.columns()) {
      names.push_back(column.name);
      writers.emplace_back(made, column, static_cast<hsize_t>(table.rows()));
    }
    add_attribute(made, "columns", names);
    add_attribute(made, "program", {description.program});
    add_attribute(made, "arguments", {description.fixed.at("arguments")});
    table.for_each_row([&](const std::vector<std::string>& row) {
      for (std::size_t i = 0; i < row.size(); ++i) writers[i].append(row[i]);
    });
    for (ColumnWriter& writer : writers) writer.flush();
    check(H5Fflush(made, H5F_SCOPE_LOCAL));
  });
}

}  // namespace prehend::tools

#else

namespace prehend::tools {

void write_hdf5(const sweep::ResultTable&, const sweep::Description&,
                const std::filesystem::path&) {
  throw text::InputError("This prehend was built without HDF5",
                         "Install libhdf5-dev and build it again, or export CSV");
}

}  // namespace prehend::tools

#endif
