// Runs a fuzz target without libFuzzer: PROGRAM FOLDER... feeds it every file of the folders, then
// mutations of them with a fixed seed, for about two seconds. The input that ends the program by a
// crash, or by taking longer than ten seconds, is left in the file finding-PROGRAM in the system's
// temporary folder.

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_input.h"

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

constexpr auto kMutationTime = std::chrono::seconds(2);
constexpr int kMostMutations = 200000;
constexpr unsigned kLongestRun = 10;  // [s]
constexpr std::size_t kLongestInput = 1 << 16;

Bytes current;
std::string finding_file;

// Only calls that are allowed in a signal handler.
void keep_finding(int signal) {
  const int file = ::open(finding_file.c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0600);
  const char text[] = "the target died or hung; its input is in the file finding-PROGRAM\n";
  const bool kept = file >= 0 && ::write(file, current.data(), current.size()) >= 0 &&
                    ::write(STDERR_FILENO, text, sizeof text - 1) > 0;
  ::signal(signal, SIG_DFL);
  ::raise(kept ? signal : SIGKILL);
}

void run(Bytes input) {
  current = std::move(input);
  ::alarm(kLongestRun);
  LLVMFuzzerTestOneInput(current.data(), current.size());
  ::alarm(0);
}

std::vector<Bytes> read_corpus(const std::vector<std::string>& folders) {
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Bytes> corpus;
  for (const fs::path& path : files) {
    std::ifstream file(path, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return corpus;
}

/// Changes an input a little, the way damage, attackers and other versions do.
class Mutator {
 public:
  explicit Mutator(const std::vector<Bytes>& corpus) : corpus_(corpus) {}

  Bytes next() {
    Bytes bytes = corpus_[below(corpus_.size())];
    for (std::size_t i = below(6); i < 6; ++i) change(bytes);
    bytes.resize(std::min(bytes.size(), kLongestInput));
    return bytes;
  }

 private:
  std::size_t below(std::size_t count) { return random_() % count; }

  void change(Bytes& bytes) {
    if (bytes.empty()) bytes.push_back(0);
    const std::size_t at = below(bytes.size());
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t length = 1 + below(std::min<std::size_t>(bytes.size() - at, 32));
    const auto end = place + static_cast<std::ptrdiff_t>(length);
    switch (below(7)) {
      case 0:
        *place ^= static_cast<std::uint8_t>(1u << below(8));
        break;
      case 1:
        *place = static_cast<std::uint8_t>(below(256));
        break;
      case 2:  // extreme numbers
        std::fill(place, end, below(2) ? std::uint8_t{0xff} : std::uint8_t{0});
        break;
      case 3:
        bytes.erase(place, end);
        break;
      case 4: {
        const Bytes part(place, end);
        bytes.insert(place, part.begin(), part.end());
        break;
      }
      case 5:
        bytes.resize(at);
        break;
      default: {  // the end of another input
        const Bytes& other = corpus_[below(corpus_.size())];
        const std::size_t from = other.empty() ? 0 : below(other.size());
        bytes.resize(at);
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
      }
    }
  }

  const std::vector<Bytes>& corpus_;
  std::mt19937 random_{20240607};
};

}  // namespace

int main(int argc, char** argv) {
  const std::string name = fs::path(argv[0]).filename();
  finding_file = fs::temp_directory_path() / ("finding-" + name);
  for (const int signal : {SIGSEGV, SIGABRT, SIGILL, SIGTRAP, SIGBUS, SIGFPE, SIGALRM}) {
    ::signal(signal, keep_finding);
  }
  const std::vector<Bytes> corpus = read_corpus({argv + 1, argv + argc});
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no inputs; give the folders they are in\n", name.c_str());
    return 1;
  }
  for (const Bytes& input : corpus) run(input);
  Mutator mutator(corpus);
  const auto end = std::chrono::steady_clock::now() + kMutationTime;
  int mutations = 0;
  while (mutations < kMostMutations && std::chrono::steady_clock::now() < end) {
    run(mutator.next());
    ++mutations;
  }
  std::printf("%s: %zu inputs and %d mutations of them\n", name.c_str(), corpus.size(), mutations);
  return 0;
}
