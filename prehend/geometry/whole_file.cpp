#include "prehend/geometry/whole_file.h"

#include <unistd.h>

#include <fstream>
#include <system_error>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {

void write_whole_file(const std::filesystem::path& file, const std::string& text,
                      const std::string& what) {
  const std::filesystem::path unfinished = file.string() + "." + std::to_string(::getpid());
  std::error_code error;
  {
    std::ofstream stream(unfinished);
    stream << text << '\n';
    stream.flush();
    if (!stream) error = std::make_error_code(std::errc::io_error);
  }
  if (!error) std::filesystem::rename(unfinished, file, error);
  if (!error) return;
  std::error_code ignored;  // there may be nothing to remove
  std::filesystem::remove(unfinished, ignored);
  throw InputError(what + " '" + file.string() + "' cannot be written",
                   "Check the folder and the space on the disk");
}

}  // namespace prehend::geometry
