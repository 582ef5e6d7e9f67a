#pragma once

#include <string>

#include "drivers/kuka_rsi/codec/telegram.h"
#include "drivers/wire/probe/probe.h"

namespace prehend::drivers::kuka_rsi {

/// Listens on UDP `port` of `host` for a controller, `seconds` at most, and answers nothing: RSI
/// corrects nothing then, and a controller that is running counts as many late answers.
/// @throws geometry::InputError where the port cannot be had.
Probe probe(const std::string& host, int port, const TelegramNames& names = {},
            double seconds = 1.5);

}  // namespace prehend::drivers::kuka_rsi
