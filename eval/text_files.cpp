#include "eval/text_files.h"

#include <fstream>
#include <stdexcept>

namespace prehend::eval {

void write_text(const std::filesystem::path& file, const std::string& text) {
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.flush();
  if (!stream) throw std::runtime_error("cannot write '" + file.string() + "'");
}

}  // namespace prehend::eval
