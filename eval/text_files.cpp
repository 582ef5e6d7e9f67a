#include "eval/text_files.h"

#include <fstream>
#include <system_error>

#include "prehend/text/input_error.h"

namespace prehend::eval {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return;
  throw text::InputError("The folder '" + folder.string() + "' cannot be made: " + error.message(),
                         "Give one that can, as with --out");
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  if (file.has_parent_path()) make_folder(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.flush();
  if (!stream) {
    throw text::InputError("'" + file.string() + "' cannot be written",
                           "Give a folder that can be written to and has room, as with --out");
  }
}

}  // namespace prehend::eval
