#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace prehend::testing {

/// A command as a document has it.
struct DocumentedCommand {
  std::string place;  ///< "FILE:LINE"
  std::string text;   ///< without comment, line continuations joined
  /// Named in a sentence: arguments may be missing.
  bool is_mention = false;
};

/// The commands of a Markdown file: of its `sh` blocks, of indented lines that begin with a program
/// of prehend, and those named in a sentence as `prehend ...`.
std::vector<DocumentedCommand> commands_of(const std::filesystem::path& markdown);

/// Says whether commands would be taken as they are written, without doing what they do.
class CommandChecker {
 public:
  /// `tree`: of the sources; `programs`: build/bin; `scratch`: an empty folder, which becomes the
  /// working directory. Files that a command names are put there as empty ones.
  CommandChecker(std::filesystem::path tree, std::filesystem::path programs,
                 std::filesystem::path scratch);

  /// "" when it would be taken, else what is wrong.
  std::string problem_of(const DocumentedCommand& command) const;

 private:
  std::string problem_of_prehend(const std::vector<std::string>& words, bool is_mention) const;
  std::string problem_of_options(const std::vector<std::string>& words) const;
  void make_named_files(const std::vector<std::string>& words) const;

  const std::filesystem::path tree_, programs_;
};

}  // namespace prehend::testing
