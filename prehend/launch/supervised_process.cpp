#include "prehend/launch/supervised_process.h"

#include <algorithm>

namespace prehend::launch {
namespace {

constexpr std::size_t kLongestLine = 16384;  // longer ones are shown in pieces

}  // namespace

void SupervisedProcess::start() {
  ready = succeeded = false;
  restart_at.reset();
  last_line_.clear();
  child_ = std::make_unique<ChildProcess>(command_, environment_, share_);
  started_ = Clock::now();
}

void SupervisedProcess::show_line(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  if (line.find_first_not_of(" \t") != std::string_view::npos) last_line_ = line;
  output_.process_line(name_, line);
}

bool SupervisedProcess::forward_output() {
  if (!child_) return false;
  const std::string text = child_->read_output();
  partial_line_ += text;
  std::size_t done = 0;
  for (auto end = partial_line_.find('\n'); end != std::string::npos;
       end = partial_line_.find('\n', done)) {
    show_line(std::string_view(partial_line_).substr(done, end - done));
    done = end + 1;
  }
  partial_line_.erase(0, done);
  if (partial_line_.size() > kLongestLine) {
    show_line(partial_line_);
    partial_line_.clear();
  }
  return !text.empty();
}

std::optional<int> SupervisedProcess::reap() {
  if (!child_) return std::nullopt;
  const auto status = child_->status();
  if (!status) return std::nullopt;
  while (forward_output()) {
  }
  if (!partial_line_.empty()) show_line(partial_line_);
  partial_line_.clear();
  peak_memory_ = std::max(peak_memory_, child_->peak_memory());
  child_.reset();
  succeeded = is_success(*status);
  return status;
}

}  // namespace prehend::launch
