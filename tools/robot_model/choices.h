#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend model` and of the program that it becomes.
struct ModelChoices {
  std::string command;  // convert, check, show, diff, formats
  std::string first, second, format, mended, page;
  bool strict = false;
  int samples = 1000;
};

/// Adds its commands. `choices` lives as long as the app.
void add_model_options(CLI::App& app, ModelChoices& choices);

}  // namespace prehend::tools
