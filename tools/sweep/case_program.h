#pragma once

#include <string>
#include <vector>

namespace prehend::tools {

/// The path of `program`: as it is said if it has a '/', else beside prehend, else on PATH.
/// @throws InputError when it is not there or is no program.
std::string case_program(const std::string& program);

/// The lines that a program prints, for the values of a parameter. @throws InputError when it fails
/// or prints nothing.
std::vector<std::string> lines_of(const std::vector<std::string>& words);

/// For a shell, which takes it as one word whatever is in it.
std::string shell_word(const std::string& word);

}  // namespace prehend::tools
