#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend model` and of the program that it becomes.
struct ModelChoices {
  std::string command;  // convert, check, show, collision, diff, formats
  std::string first, second, format, mended, page;
  std::vector<std::string> links;
  std::string collision = "pieces";
  std::optional<double> concavity;  // m
  bool strict = false;
  int samples = 1000;
};

/// Adds its commands. `choices` lives as long as the app.
void add_model_options(CLI::App& app, ModelChoices& choices);

}  // namespace prehend::tools
