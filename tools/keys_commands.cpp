#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "prehend/graph/security.h"
#include "tools/commands.h"

namespace prehend::tools {
namespace {

constexpr const char* kDefaultFile = "graph.keys";

void create(const std::string& file) {
  const graph::GraphKeys keys = graph::create_graph_keys(file);
  std::printf(
      "%s: made, only you can read it. Copy it to every host of the graph (scp -p) and give it to "
      "the registry and all nodes with --keys, or as PREHEND_KEYS.\npublic key: %s\n",
      file.c_str(), keys.public_key.c_str());
}

void show(const std::string& file) {
  const char* from_environment = std::getenv("PREHEND_KEYS");
  const std::string fallback =
      from_environment && *from_environment ? from_environment : kDefaultFile;
  const std::string& named = file.empty() ? fallback : file;
  std::printf("%s: public key: %s\n", named.c_str(),
              graph::load_graph_keys(named).public_key.c_str());
}

}  // namespace

void add_keys_commands(CLI::App& app) {
  CLI::App* group = app.add_subcommand("keys", "Make and look at the keys of a graph");
  group->require_subcommand(1);
  auto created = std::make_shared<std::string>(kDefaultFile);
  auto shown = std::make_shared<std::string>();
  CLI::App* create_command = group->add_subcommand(
      "create", "Make the keys that let a graph reach over more than one host");
  create_command->add_option("file", *created, "The file to write; it must not exist")
      ->capture_default_str();
  create_command->footer(
      "Whoever has the file is a member of the graph.\n\n"
      "Example:\n  prehend keys create robot.keys");
  create_command->callback([created] { create(*created); });
  CLI::App* show_command =
      group->add_subcommand("show", "Check a key file and print its public part");
  show_command->add_option("file", *shown, "The key file; default: PREHEND_KEYS, else graph.keys");
  show_command->footer("Example:\n  prehend keys show robot.keys");
  show_command->callback([shown] { show(*shown); });
}

void add_security_options(CLI::App& command) {
  // The environment carries it to everything the command starts or asks.
  command
      .add_option_function<std::string>(
          "--keys",
          [](const std::string& file) {
            ::setenv("PREHEND_KEYS", std::filesystem::absolute(file).c_str(), 1);
          },
          "Key file of the graph, see prehend keys; default: PREHEND_KEYS, else none")
      ->check(CLI::ExistingFile);
  command.add_option_function<std::string>(
      "--bind", [](const std::string& address) { ::setenv("PREHEND_BIND", address.c_str(), 1); },
      "Address of this host at which nodes of other hosts connect, needs keys; default: "
      "PREHEND_BIND, else none");
}

}  // namespace prehend::tools
