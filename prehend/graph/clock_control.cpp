#include "prehend/graph/clock_control.h"

#include <stdexcept>
#include <utility>

namespace prehend::graph {
namespace {

using msgs::graph::ClockControlRequest;
using msgs::graph::ClockControlResponse;

void execute(ClockPacer& pacer, const ClockControlRequest& request) {
  switch (request.command()) {
    case ClockControlRequest::STATUS:
      return;
    case ClockControlRequest::PAUSE:
      return pacer.pause();
    case ClockControlRequest::RESUME:
      return pacer.resume();
    case ClockControlRequest::STEP:
      return pacer.step(request.step());
    case ClockControlRequest::SET_SPEED:
      return pacer.set_speed(request.speed());
    default:
      throw std::invalid_argument("clock control knows no command " +
                                  std::to_string(request.command()));
  }
}

}  // namespace

ClockControlResponse control(ClockPacer& pacer, const ClockControlRequest& request) {
  ClockControlResponse response;
  try {
    execute(pacer, request);
  } catch (const std::invalid_argument& error) {
    response.set_error(error.what());
  }
  const ClockPacer::State state = pacer.state();
  response.set_paused(state.paused);
  response.set_speed(state.speed);
  response.set_time(state.time);
  return response;
}

ClockControl::ClockControl(Node& node, ClockPacer& pacer, std::function<void(double)> on_speed)
    : service_(node.serve<ClockControlRequest, ClockControlResponse>(
          kClockControlService,
          [&pacer, on_speed = std::move(on_speed)](const ClockControlRequest& request) {
            const auto response = control(pacer, request);
            const bool speed_set =
                request.command() == ClockControlRequest::SET_SPEED && response.error().empty();
            if (speed_set && on_speed) on_speed(request.speed());
            return response;
          })) {}

}  // namespace prehend::graph
