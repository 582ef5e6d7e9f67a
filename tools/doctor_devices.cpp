#include "tools/doctor_devices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>
#include <optional>
#include <string_view>

#include "drivers/barrett/driver/gcl/probe.h"
#include "drivers/barrett/driver/probe.h"
#include "drivers/camera/driver/probe.h"
#include "drivers/dsa/driver/probe.h"
#include "drivers/ft300/driver/probe.h"
#include "drivers/kuka_rsi/driver/probe.h"
#include "drivers/kuka_rsi/transport/udp_socket.h"
#include "drivers/pg70/driver/probe.h"
#include "drivers/sdh/driver/probe.h"
#include "drivers/wire/stream/line_users.h"
#include "prehend/geometry/errors.h"

namespace prehend::tools {
namespace {

using Level = Finding::Level;
using drivers::Probe;

Level level_of(Probe::Result result) {
  switch (result) {
    case Probe::Result::kAnswers:
      return Level::kOk;
    case Probe::Result::kWarns:
      return Level::kWarning;
    default:
      return Level::kError;
  }
}

// An InputError is "thing. mend."
Finding finding_of(const std::string& subject, const geometry::InputError& error) {
  std::string what = error.what();
  const std::size_t end = what.find(". ");
  if (end == std::string::npos) return {Level::kError, subject, what, ""};
  std::string mend = what.substr(end + 2);
  if (mend.ends_with('.')) mend.pop_back();
  return {Level::kError, subject, what.substr(0, end), mend};
}

// The file of a line; empty for networks and interfaces.
std::string device_file(std::string line) {
  for (const std::string_view prefix : {"slcan:", "serial:"}) {
    if (line.starts_with(prefix)) line.erase(0, prefix.size());
  }
  return line.starts_with('/') ? line : std::string();
}

// What the probe finds, unless another process uses the line: two readers of a serial line each get
// a part of the bytes.
Findings examine(const std::string& subject, const std::string& line,
                 const std::function<Findings()>& probe) {
  const std::string file = device_file(line);
  const auto users = file.empty() ? std::vector<drivers::LineUser>() : drivers::users_of_line(file);
  if (!users.empty()) {
    const auto& user = users.front();
    return {{Level::kWarning, subject,
             fmt::format("{} is in use by {} (process {}), so it was not asked", file, user.program,
                         user.pid),
             fmt::format("see what this page says of node {0}, or stop process {1} and ask again",
                         user.program, user.pid)}};
  }
  try {
    return probe();
  } catch (const geometry::InputError& error) {
    return {finding_of(subject, error)};
  } catch (const std::exception& error) {
    return {{Level::kError, subject, error.what(), ""}};
  }
}

Finding finding_of(const std::string& subject, const Probe& probe) {
  return {level_of(probe.result), subject, probe.what, probe.mend};
}

// Why not all module ids are asked; nothing when nobody else is on the line. First of all, as what
// is asked of one module makes it talk.
std::optional<Finding> reason_against_scan(const drivers::pg70::LinkAddress& address) {
  const drivers::pg70::OtherTraffic traffic = drivers::pg70::listen(address);
  if (!traffic.any()) return std::nullopt;
  std::string who;
  if (!traffic.modules.empty()) {
    who = fmt::format("module {} is in use", fmt::join(traffic.modules, ", "));
  }
  if (traffic.others > 0) {
    who += fmt::format("{}{} messages of other devices in a second", who.empty() ? "" : ", ",
                       traffic.others);
  }
  return Finding{Level::kWarning, "gripper",
                 fmt::format("others share {} ({}), so the 255 module ids were not asked: what is "
                             "sent to an id that is not a gripper's may mean anything to its owner",
                             address.line, who),
                 "stop them, or take the gripper to a line of its own; --scan --shared-bus asks "
                 "nevertheless"};
}

Findings ask_gripper(const DeviceChoices& choices) {
  const drivers::pg70::LinkAddress address{choices.can, static_cast<unsigned>(choices.bit_rate),
                                           static_cast<std::uint8_t>(choices.module_id)};
  const auto against =
      choices.scan && !choices.shared ? reason_against_scan(address) : std::optional<Finding>();
  Findings findings{finding_of("gripper", drivers::pg70::probe(address))};
  if (against) findings.push_back(*against);
  if (!choices.scan || against) return findings;
  const auto modules = drivers::pg70::find_modules(address);
  if (modules.empty()) {
    findings.push_back({Level::kError, "gripper",
                        "no module id of 1 to 255 answers on " + address.line,
                        "check supply, wiring, termination and bit rate"});
  } else {
    const bool is_there = modules.contains(address.module);
    findings.push_back(
        {is_there ? Level::kOk : Level::kError, "gripper",
         fmt::format("module ids that answer on {}: {}", address.line, fmt::join(modules, ", ")),
         is_there ? "" : fmt::format("module_id:={}", *modules.begin())});
  }
  return findings;
}

Findings listen_for_arm(const DeviceChoices& choices) {
  try {
    return {finding_of("arm", drivers::kuka_rsi::probe(choices.rsi_host, choices.rsi_port))};
  } catch (const drivers::kuka_rsi::UdpPortTaken&) {
    return {
        {Level::kWarning, "arm",
         fmt::format("UDP port {} is in use, by its driver it is hoped, so nobody listened there",
                     choices.rsi_port),
         "see what this page says of node kuka_rsi, or stop it and ask again"}};
  }
}

}  // namespace

Findings examine_devices(const DeviceChoices& choices) {
  Findings findings;
  const auto add = [&](const Findings& more) {
    findings.insert(findings.end(), more.begin(), more.end());
  };
  if (!choices.can.empty()) {
    add(examine("gripper", choices.can, [&] { return ask_gripper(choices); }));
  }
  if (!choices.dsa.empty()) {
    add(examine("touch", choices.dsa,
                [&] { return Findings{finding_of("touch", drivers::dsa::probe(choices.dsa))}; }));
  }
  if (!choices.ft300.empty()) {
    add(examine("force", choices.ft300, [&] {
      constexpr unsigned kBaud = 19200;
      return Findings{finding_of(
          "force",
          drivers::ft300::probe(choices.ft300, kBaud, static_cast<std::uint8_t>(choices.unit)))};
    }));
  }
  if (!choices.sdh.empty()) {
    add(examine("hand", choices.sdh,
                [&] { return Findings{finding_of("hand", drivers::sdh::probe(choices.sdh))}; }));
  }
  if (!choices.barrett.empty()) {
    add(examine("hand", choices.barrett, [&] {
      // A BH8-262 has a serial line, a BH8-280 a bus.
      const std::string& wire = choices.barrett;
      const bool is_line = wire.starts_with('/') || wire.starts_with("tcp://");
      return Findings{finding_of(
          "hand", is_line ? drivers::barrett::gcl::probe(wire) : drivers::barrett::probe(wire))};
    }));
  }
  if (choices.rsi_port > 0) add(examine("arm", "", [&] { return listen_for_arm(choices); }));
  if (choices.cameras) {
    for (const Probe& probe : drivers::camera::find_cameras()) {
      findings.push_back(finding_of("cameras", probe));
    }
  }
  for (const std::string& device : choices.camera) {
    // To ask it what it is disturbs nobody; what is no camera may be open anywhere.
    const Probe probe = drivers::camera::probe_camera(device);
    const Findings answer{finding_of("camera", probe)};
    add(probe.result == Probe::Result::kAnswers ? examine("camera", device, [&] { return answer; })
                                                : answer);
  }
  for (const std::string& uri : choices.depth_camera) {
    findings.push_back(finding_of("depth camera", drivers::camera::probe_depth_camera(uri)));
  }
  return findings;
}

}  // namespace prehend::tools
