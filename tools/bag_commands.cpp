#include <memory>

#include "tools/bag_convert/choices.h"
#include "tools/bag_import/choices.h"
#include "tools/bag_tools.h"
#include "tools/commands.h"
#include "tools/given_words.h"
#include "tools/programs.h"

namespace prehend::tools {
namespace {

struct BagChoices {
  std::string file, output, folder, name;
  std::vector<std::string> topics;
  bool json = false;
};

void add_looks(CLI::App& group, const std::shared_ptr<BagChoices>& choices, Outcome& outcome) {
  CLI::App* info = group.add_subcommand("info", "Say what a recording holds and lacks");
  info->add_option("file", choices->file, "The recording (MCAP)")->required();
  info->add_flag("--json", choices->json, "Print JSON");
  info->footer("Example:\n  prehend bag info run.mcap");
  info->callback(
      [choices, &outcome] { outcome.exit_code = bag_info(choices->file, choices->json); });
  CLI::App* check = group.add_subcommand(
      "check", "Verify checksums, indexes, order and every message; exit code 1 when not sound");
  check->add_option("file", choices->file, "The recording")->required();
  check->add_flag("--json", choices->json, "Print JSON");
  check->footer("Example:\n  prehend bag check run.mcap");
  check->callback(
      [choices, &outcome] { outcome.exit_code = bag_check(choices->file, choices->json); });
  CLI::App* attachments =
      group.add_subcommand("attachments", "List the files kept in a recording, or extract them");
  attachments->add_option("file", choices->file, "The recording")->required();
  attachments->add_option("-o,--output", choices->folder, "Folder to write them to");
  attachments->add_option("-n,--name", choices->name, "Only this one");
  attachments->footer("Example:\n  prehend bag attachments run.mcap -o run_files");
  attachments->callback([choices, &outcome] {
    outcome.exit_code = bag_attachments(choices->file, choices->folder, choices->name);
  });
}

void add_recover(CLI::App& group, const std::shared_ptr<BagChoices>& choices, Outcome& outcome) {
  CLI::App* mend = group.add_subcommand(
      "recover", "Copy what can be read of a damaged or unfinished recording to a new one");
  mend->add_option("file", choices->file, "The damaged recording")->required();
  mend->add_option("output", choices->output, "The new file")->required();
  mend->footer(
      "A recorder that was killed leaves FILE.partial; FILE finds it, too.\n\n"
      "Example:\n  prehend bag recover killed.mcap mended.mcap");
  mend->callback(
      [choices, &outcome] { outcome.exit_code = bag_recover(choices->file, choices->output); });
}

void add_filter(CLI::App& group, Outcome& outcome) {
  auto filter = std::make_shared<BagFilter>();
  CLI::App* command =
      group.add_subcommand("filter", "Copy some topics or some time of a recording to a new one");
  command->add_option("file", filter->from, "The recording")->required();
  command->add_option("output", filter->to, "The new file")->required();
  command->add_option("-t,--topics", filter->topics, "Only these, * for any text");
  command->add_option("-x,--without", filter->without, "But not these");
  command->add_option("-s,--start", filter->start, "From here, after its beginning: 2.5s");
  command->add_option("-e,--end", filter->end, "Up to here, after its beginning: 1min");
  command->add_option("--compression", filter->compression, "none, lz4 or zstd")
      ->check(CLI::IsMember({"none", "lz4", "zstd"}))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  prehend bag filter run.mcap small.mcap --without '/camera/*' --compression zstd\n"
      "  prehend bag filter run.mcap part.mcap --start 10s --end 15s");
  command->callback([filter, &outcome] { outcome.exit_code = bag_filter(*filter); });
}

// A program of its own: only who exports pays for loading the libraries of images and clouds.
void add_export(CLI::App& group, const std::shared_ptr<BagChoices>& choices) {
  CLI::App* command = group.add_subcommand(
      "export", "Write images as PNG, clouds as PCD, and all other fields as CSV");
  command->add_option("file", choices->file, "The recording")->required();
  command->add_option("folder", choices->folder, "Where to write, a folder for each topic")
      ->required();
  command->add_option("-t,--topics", choices->topics, "Only these, * for any text");
  command->footer("Example:\n  prehend bag export run.mcap run_files --topics '/tactile/*'");
  command->callback([choices] {
    std::vector<std::string> words{choices->file, choices->folder};
    words.insert(words.end(), choices->topics.begin(), choices->topics.end());
    become_program("bag_export", words);
  });
}

// Likewise.
void add_convert(CLI::App& group) {
  auto choices = std::make_shared<BagConvertChoices>();
  CLI::App* command = group.add_subcommand(
      "convert", "Copy a recording with what viewers draw: scenes, clouds, pictures, frames, log");
  add_bag_convert_options(*command, *choices);
  command->footer(
      "Foxglove and Lichtblick show robot, cloud, predicted shapes, grasps and frames of the new "
      "file without more: add a 3D panel, and choose /viewer/...\n\n"
      "Examples:\n"
      "  prehend bag convert run.mcap shown.mcap --platform kr5_sdh\n"
      "  prehend bag convert run.mcap small.mcap --platform kr5_sdh --only-views");
  command->callback([command, choices] { become_program("bag_convert", given_words(*command)); });
}

// Likewise.
void add_import(CLI::App& group) {
  auto choices = std::make_shared<BagImportChoices>();
  CLI::App* command = group.add_subcommand(
      "import", "Make a recording of a bag of ROS 1 or an MCAP file of ROS 2, to be replayed");
  add_bag_import_options(*command, *choices);
  command->footer(
      "Taken are Image, CompressedImage, CameraInfo, PointCloud2, JointState and WrenchStamped, on "
      "their own topics; with --stereo or --depth, what segmentation looks at.\n\n"
      "Examples:\n"
      "  prehend bag import table.bag table.mcap --depth /camera/depth/image_rect_raw\n"
      "  prehend bag import table.bag table.mcap --stereo /left/image_rect /right/image_rect\n"
      "  prehend launch launch/replay.yaml bag:=table.mcap input:=depth world:=table");
  command->callback([command, choices] { become_program("bag_import", given_words(*command)); });
}

}  // namespace

void add_bag_commands(CLI::App& app, Outcome& outcome) {
  CLI::App* group =
      app.add_subcommand("bag", "Look at, cut, convert, import, export and mend recordings");
  group->require_subcommand(1);
  auto choices = std::make_shared<BagChoices>();
  add_looks(*group, choices, outcome);
  add_recover(*group, choices, outcome);
  add_filter(*group, outcome);
  add_convert(*group);
  add_export(*group, choices);
  add_import(*group);
}

}  // namespace prehend::tools
