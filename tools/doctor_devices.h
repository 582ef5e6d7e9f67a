#pragma once

#include <string>
#include <vector>

#include "tools/finding.h"

namespace prehend::tools {

/// The devices to ask, named as in launch/bringup.yaml; an empty line: not asked.
struct DeviceChoices {
  std::string can;  ///< "can0", "slcan:/dev/ttyACM0", "serial:/dev/ttyUSB2"
  int module_id = 12;
  int bit_rate = 0;     ///< of `can`, 0: as it is
  bool scan = false;    ///< asks all module ids, unless others talk on the line
  bool shared = false;  ///< asks them nevertheless
  std::string dsa, ft300, sdh;
  /// Of a BarrettHand: bus of a BH8-280, "can0", "slcan:/dev/ttyACM0"; line of a BH8-262,
  /// "/dev/ttyUSB2", "tcp://HOST:PORT".
  std::string barrett;
  int unit = 9;                           ///< Modbus address of the force sensor
  int rsi_port = 0;                       ///< UDP port that a KUKA sends to; 0: not listened to
  std::string rsi_host;                   ///< address of this machine of the same
  bool cameras = false;                   ///< lists V4L2 devices and depth cameras of OpenNI2
  std::vector<std::string> camera;        ///< V4L2 devices: "/dev/video0"
  std::vector<std::string> depth_camera;  ///< URIs of OpenNI2, recordings, prehend://HOST:PORT

  bool any() const {
    return !can.empty() || !dsa.empty() || !ft300.empty() || !sdh.empty() || !barrett.empty() ||
           rsi_port > 0 || cameras || !camera.empty() || !depth_camera.empty();
  }
};

/// Asks the devices by the drivers' own codecs, nothing of which moves them: whether the line can
/// be opened, is that of another process, and who answers on it. Takes some seconds for devices
/// that are silent.
Findings examine_devices(const DeviceChoices& choices);

}  // namespace prehend::tools
