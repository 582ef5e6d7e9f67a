#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

namespace prehend::report {

/// A program that makes an SVG picture of a script.
struct DrawingProgram {
  std::string name;
  std::string command;  // reads the file `script`, writes chart.svg; both in the working directory
  std::string package;  // of Debian
};

/// Runs the program on the script that `write` puts into a folder of its own, beside which it may
/// put data. @return the SVG element, without the XML prologue, so that it can stand inside a page.
/// @throws std::runtime_error with what the program says, and its package.
std::string drawn_by(
    const DrawingProgram& program, const std::string& title,
    const std::function<void(const std::filesystem::path& folder, std::ostream& script)>& write);

}  // namespace prehend::report
