#include "msgs/convert/fidelity.h"

#include <cstdint>

namespace prehend::convert {

msgs::FidelityChoice to_message(const fidelity::Setting& setting, const std::string& measured) {
  msgs::FidelityChoice message;
  message.set_knobs(fidelity::to_string(setting));
  message.set_seconds(setting.seconds);
  message.set_error(setting.error);
  message.set_measured(measured);
  return message;
}

msgs::FidelityChoice to_message(const fidelity::Front& front, const fidelity::Setting& setting,
                                const std::string& measured) {
  msgs::FidelityChoice message = to_message(setting, measured);
  for (const fidelity::Setting& one : front.settings) {
    if (one.knobs == setting.knobs) {
      message.set_chosen(static_cast<std::uint32_t>(message.front_size()));
    }
    msgs::FidelityPoint& point = *message.add_front();
    point.set_seconds(one.seconds);
    point.set_error(one.error);
    for (const auto& [name, value] : one.other_errors) {
      if (name == "mesh") point.set_mesh(value);
    }
  }
  message.set_subject(front.subject);
  message.set_error_name(front.error_name);
  message.set_error_unit(front.error_unit);
  return message;
}

}  // namespace prehend::convert
