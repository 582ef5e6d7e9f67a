#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace prehend::drivers {

/// Waits until it holds; false after `time`, which is far more than it takes.
inline bool eventually(const std::function<bool()>& condition,
                       std::chrono::milliseconds time = std::chrono::seconds(20)) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// The remarks of a device. Thread-safe.
class Notes {
 public:
  std::function<void(bool, const std::string&)> taker() {
    return [this](bool, const std::string& words) {
      const std::lock_guard lock(mutex_);
      words_.push_back(words);
    };
  }
  bool has(const std::string& part) const {
    const std::lock_guard lock(mutex_);
    for (const std::string& words : words_) {
      if (words.find(part) != std::string::npos) return true;
    }
    return false;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> words_;
};

}  // namespace prehend::drivers
