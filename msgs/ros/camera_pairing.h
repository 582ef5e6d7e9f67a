#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace prehend::ros {

/// What nodes of prehend look at, on /camera/stereo or /camera/depth with /camera/info, made of
/// pictures and calibrations of one or two topics of ROS.
class CameraPairing {
 public:
  /// Takes what was made: its topic, its time [ns], the message.
  using Write = std::function<void(const std::string& topic, std::uint64_t time,
                                   const google::protobuf::Message& message)>;
  virtual ~CameraPairing() = default;
  /// Topics of ROS with images, and those with their calibrations: camera_info beside the image, as
  /// image_transport and the drivers have it.
  virtual std::vector<std::string> pictures() const = 0;
  virtual std::vector<std::string> calibrations() const = 0;
  bool needs(const std::string& topic) const;
  /// @param message one that from_ros() made of a topic's. @throws std::runtime_error for one that
  /// cannot be such a picture; it is left out.
  virtual void take(const std::string& topic, std::uint64_t time,
                    const google::protobuf::Message& message, const Write& write) = 0;
  /// @returns what is worth telling. @throws std::runtime_error when nothing came of it.
  virtual std::string finish(const Write& write) = 0;
};

/// Images whose stamps agree within 2 ms. @param left, right rectified images of a pair
std::unique_ptr<CameraPairing> pair_stereo(const std::string& left, const std::string& right);

/// @param depth images in mm (16UC1) or m (32FC1). @param color registered to them, the nearest
/// within 50 ms; empty: none
std::unique_ptr<CameraPairing> pair_depth(const std::string& depth, const std::string& color);

}  // namespace prehend::ros
