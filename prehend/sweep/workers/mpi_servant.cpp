#include "prehend/sweep/workers/mpi_servant.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

namespace prehend::sweep {
namespace {

// Rank 0 says nothing while it reads a long description or old results.
constexpr double kPatience = 600;  // s
// While a case runs only its end, which a signal tells, is urgent.
constexpr double kLookAside = 0.02;  // s
constexpr double kTaken = 5;         // s, for the last messages

double elapsed_since(std::chrono::steady_clock::time_point then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

}  // namespace

int MpiServant::serve() {
  int code = 0;
  while (!is_to_end_) {
    if (elapsed_since(heard_) > kPatience) {
      running_.reset();
      throw std::runtime_error(
          fmt::format("Rank {} ({}) has heard nothing of rank 0 for {} s and ends",
                      post_.world().rank(), where_, kPatience));
    }
    try {
      say_alive();
      listen();
      look_after_case();
    } catch (const boost::mpi::exception&) {
      throw;  // rank 0 cannot be told
    } catch (const std::exception& error) {
      code = 1;
      post_.send(0, kFailed, std::string(error.what()));
      leave();
    }
    if (is_to_end_) break;
    const double seconds = running_ ? std::min(kLookAside, running_->seconds_left()) : kLook;
    if (wait_for_signal(seconds)) leave();
  }
  leave();
  post_.flush(kTaken);
  return code;
}

void MpiServant::leave() {
  if (is_leaving_) return;
  is_leaving_ = true;
  running_.reset();
  post_.send(0, kGone);
}

void MpiServant::say_alive() {
  if (is_leaving_ || elapsed_since(said_) < kSign) return;
  said_ = Clock::now();
  post_.send(0, kAlive, where_);
}

void MpiServant::listen() {
  while (const auto message = post_.world().iprobe(0, boost::mpi::any_tag)) {
    heard_ = Clock::now();
    if (message->tag() == kRun) {
      CaseOrder order;
      post_.world().recv(0, kRun, order);
      if (!is_leaving_) running_ = std::make_unique<CaseProcess>(std::move(order), body_);
    } else {
      post_.world().recv(0, message->tag());
      is_to_end_ = is_to_end_ || message->tag() == kStop;
    }
  }
}

void MpiServant::look_after_case() {
  const std::optional<CaseEnd> end = running_ ? running_->poll() : std::nullopt;
  if (!end) return;
  running_.reset();
  post_.send(0, kEnd, *end);
}

}  // namespace prehend::sweep
