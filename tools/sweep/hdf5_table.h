#pragma once

#include <filesystem>

#include "prehend/sweep/table.h"

namespace prehend::tools {

/// The table as one HDF5 file, whole or not at all: a dataset a column, all of the same length,
/// int64 for whole numbers, float64 for numbers (NaN where there is none), else UTF-8 text. The
/// attribute `columns` has their names in order, `program` and `arguments` are as described. It has
/// no time stamps. @throws InputError when it cannot be written, or where this program was built
/// without HDF5.
void write_hdf5(const sweep::ResultTable& table, const sweep::Description& description,
                const std::filesystem::path& file);

}  // namespace prehend::tools
