#include "tests/system/documented_commands.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <wordexp.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// What documents use besides prehend's own programs.
const std::set<std::string> kForeign{"sudo", "candump", "cmake", "ninja", "export", "source",
                                     "scp",  "cd",      "git",   "npm",   "npx",    "python3"};

std::string text_of_document(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Run {
  int exit_code = -1;
  std::string output;
};

Run run_words(const Words& words) {
  Run run;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
  Words copies = words;
  std::vector<char*> pointers;
  for (std::string& word : copies) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    ::execv(pointers[0], pointers.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  char buffer[4096];
  for (ssize_t got = 0; (got = ::read(ends[0], buffer, sizeof buffer)) > 0;) {
    run.output.append(buffer, static_cast<std::size_t>(got));
  }
  ::close(ends[0]);
  int status = 0;
  ::waitpid(pid, &status, 0);
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return run;
}

// Calls `take` for each character outside quotes.
template <class Take>
void outside_quotes(const std::string& line, Take take) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote != 0) {
      if (line[i] == quote) quote = 0;
    } else if (line[i] == '"' || line[i] == '\'') {
      quote = line[i];
    } else if (!take(i)) {
      return;
    }
  }
}

std::string without_comment(const std::string& line) {
  std::size_t end = line.size();
  outside_quotes(line, [&](std::size_t i) {
    const bool begins = line[i] == '#' && (i == 0 || line[i - 1] == ' ');
    if (begins) end = i;
    return !begins;
  });
  return line.substr(0, end);
}

// Several commands on one line: after ; & && | or in columns.
Words commands_on(const std::string& line) {
  static const std::regex kColumn("^ {2,}(prehend|build/bin/[a-z_0-9]+|make) .*");
  Words commands;
  std::size_t begin = 0;
  outside_quotes(line, [&](std::size_t i) {
    const bool in_column = line[i] == ' ' && i > begin && std::regex_match(line.substr(i), kColumn);
    if (line[i] == ';' || line[i] == '&' || line[i] == '|' || in_column) {
      commands.push_back(line.substr(begin, i - begin));
      begin = i + 1;
    }
    return true;
  });
  commands.push_back(line.substr(begin));
  std::erase_if(commands, [](const std::string& command) {
    return command.find_first_not_of(" \t") == std::string::npos;
  });
  return commands;
}

// As a shell would split it. Throws std::runtime_error when it would not.
Words words_of(const std::string& command) {
  // [name:=value] is an argument that may be left out.
  static const std::regex kOptional(R"(\[([A-Za-z_]+:=("[^"]*"|[^\]\s]*))\])");
  const std::string text = std::regex_replace(command, kOptional, "$1");
  wordexp_t expanded{};
  if (::wordexp(text.c_str(), &expanded, WRDE_NOCMD) != 0) {
    throw std::runtime_error("a shell does not take it");
  }
  Words words(expanded.we_wordv, expanded.we_wordv + expanded.we_wordc);
  ::wordfree(&expanded);
  static const std::regex kAssignment("[A-Za-z_]+=.*");
  while (!words.empty() && std::regex_match(words.front(), kAssignment)) words.erase(words.begin());
  return words;
}

}  // namespace

std::vector<DocumentedCommand> commands_of(const fs::path& markdown) {
  static const std::regex kIndented("^    (prehend|build/bin/[a-z_0-9]+) .*");
  static const std::regex kMention("`(prehend [^`]+)`");
  std::vector<DocumentedCommand> commands;
  std::istringstream lines(text_of_document(markdown));
  std::string line, continued, block;
  bool in_block = false;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::string place = markdown.string() + ":" + std::to_string(number);
    if (line.starts_with("```")) {
      in_block = !in_block;
      block = line.substr(3);
      continue;
    }
    if (!in_block) {
      for (std::sregex_iterator m(line.begin(), line.end(), kMention), end; m != end; ++m) {
        commands.push_back({place, (*m)[1], true});
      }
    }
    if (in_block ? block != "sh" : !std::regex_match(line, kIndented)) continue;
    line = continued + without_comment(line);
    continued.clear();
    if (const auto last = line.find_last_not_of(' ');
        last != std::string::npos && line[last] == '\\') {
      continued = line.substr(0, last);
      continue;
    }
    for (const std::string& command : commands_on(line)) commands.push_back({place, command});
  }
  return commands;
}

CommandChecker::CommandChecker(fs::path tree, fs::path programs, fs::path scratch)
    : tree_(std::move(tree)), programs_(std::move(programs)) {
  fs::current_path(scratch);
  for (const char* folder : {"config", "launch"}) {
    fs::create_directory_symlink(tree_ / folder, scratch / folder);
  }
}

std::string CommandChecker::problem_of(const DocumentedCommand& command) const {
  Words words;
  try {
    words = words_of(command.text);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  if (words.empty()) return "";  // assignments alone
  const std::string program = fs::path(words.front()).filename().string();
  words.erase(words.begin());
  if (kForeign.count(program) > 0) return "";
  if (program == "make") {
    const std::string makefile = text_of_document(tree_ / "Makefile");
    for (const std::string& target : words) {
      if (makefile.find("\n" + target + ":") == std::string::npos) return "no target " + target;
    }
    return "";
  }
  if (fs::exists(tree_ / "scripts" / program)) return "";
  make_named_files(words);
  if (program == "prehend") return problem_of_prehend(words, command.is_mention);
  words.insert(words.begin(), (programs_ / program).string());
  if (!fs::exists(words.front())) return "there is no program " + program;
  return problem_of_options(words);
}

void CommandChecker::make_named_files(const Words& words) const {
  for (const std::string& word : words) {
    const auto equals = word.find('=');
    const fs::path file = equals == std::string::npos ? word : word.substr(equals + 1);
    if (!file.has_extension() || file.is_absolute() || fs::exists(file)) continue;
    if (fs::is_symlink(*file.begin())) continue;  // the tree is left alone
    if (file.has_parent_path()) fs::create_directories(file.parent_path());
    std::ofstream made(file);
  }
}

std::string CommandChecker::problem_of_prehend(const Words& words, bool is_mention) const {
  Words all{(programs_ / "prehend").string(), "__parse"};
  all.insert(all.end(), words.begin(), words.end());
  if (is_mention) all.emplace_back("--help");  // names are known, whatever is missing
  const Run parsed = run_words(all);
  if (parsed.exit_code != 0) return parsed.output;
  const bool starts = !words.empty() && words.front() == "launch" && !is_mention;
  for (const std::string& word : words) {
    if (word == "--check" || word == "--help") return "";
  }
  if (!starts) return "";
  all[1] = "launch";
  all.erase(all.begin() + 2);
  all.emplace_back("--dry-run");
  const Run resolved = run_words(all);
  return resolved.exit_code == 0 ? "" : resolved.output;
}

// Every option has to be in the program's help. What only chooses from a file is done.
std::string CommandChecker::problem_of_options(const Words& words) const {
  if (fs::path(words.front()).filename() == "eval_tradeoff" && words.size() > 2) {
    for (const std::string& word : words) {
      if (word != "--budget" && word != "--tolerance") continue;
      const Run run = run_words(words);
      return run.exit_code == 0 ? "" : run.output;
    }
  }
  Words help{words.front()};
  for (std::size_t i = 1; i < words.size() && !words[i].starts_with('-'); ++i) {
    help.push_back(words[i]);
  }
  help.emplace_back("--help");
  const Run run = run_words(help);
  if (run.exit_code != 0) return run.output;
  for (const std::string& word : words) {
    if (!word.starts_with("--") || word == "--") continue;
    const std::string name = word.substr(0, word.find('='));
    bool found = false;
    for (auto at = run.output.find(name); at != std::string::npos && !found;
         at = run.output.find(name, at + 1)) {
      const char next = (run.output + " ")[at + name.size()];
      found = !std::isalnum(static_cast<unsigned char>(next)) && next != '-';
    }
    if (!found) return "no option " + name;
  }
  return "";
}

}  // namespace prehend::testing
