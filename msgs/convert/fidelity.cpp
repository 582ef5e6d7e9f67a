#include "msgs/convert/fidelity.h"

namespace prehend::convert {

msgs::FidelityChoice to_message(const fidelity::Setting& setting) {
  msgs::FidelityChoice message;
  message.set_knobs(fidelity::to_string(setting));
  message.set_seconds(setting.seconds);
  message.set_error(setting.error);
  return message;
}

}  // namespace prehend::convert
