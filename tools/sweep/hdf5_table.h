#pragma once

#include <filesystem>
#include <string>

#include "prehend/sweep/table.h"

namespace prehend::tools {

/// For the time before the work is done. @throws InputError where this program was built without
/// HDF5.
void check_hdf5();

/// The table as one HDF5 file, whole or not at all: a group `/results` with a one-dimensional data
/// set for each column, in the order of the columns and all of the same length: int64 for whole
/// numbers, float64 for numbers (NaN where there is none), else UTF-8 text of variable length. A
/// '/' in a column's name is ':' there, as it would make a group. Attributes of the group:
/// `description` is as given, `failed` how many cases did. It has no times: equal tables are equal
/// files, byte by byte. @throws InputError when it cannot be written, two columns would have one
/// name, a text has a zero character, or where this program was built without HDF5.
void write_hdf5(const sweep::ResultTable& table, const std::string& description,
                const std::filesystem::path& file);

}  // namespace prehend::tools
