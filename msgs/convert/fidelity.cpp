#include "msgs/convert/fidelity.h"

namespace prehend::convert {

msgs::FidelityChoice to_message(const fidelity::Setting& setting, const std::string& measured) {
  msgs::FidelityChoice message;
  message.set_knobs(fidelity::to_string(setting));
  message.set_seconds(setting.seconds);
  message.set_error(setting.error);
  message.set_measured(measured);
  return message;
}

}  // namespace prehend::convert
