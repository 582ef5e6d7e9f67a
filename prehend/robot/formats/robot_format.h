#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/shape_mesh.h"

namespace prehend::robot::formats {

class XmlElement;

/// A format of files that describe robots. A new one is a file here, and a line in robot_formats().
class RobotFormat {
 public:
  virtual ~RobotFormat() = default;
  virtual std::string name() const = 0;  // "urdf"
  /// Whether a document with that root element is one of its.
  virtual bool recognises(const XmlElement& root) const = 0;
  /// Whether a file that begins so is one of its: of formats that are no XML.
  virtual bool recognises_text(std::string_view /*head*/) const { return false; }
  virtual std::string ending() const = 0;  // of files that are written, ".urdf"
  /// Reads all that the file says; what is not in the description is in `loss`.
  /// @throws geometry::InputError "FILE:LINE: what is wrong" with the mend
  virtual RobotDescription read(const std::filesystem::path& file, LossReport& loss) const = 0;
  virtual bool can_write() const { return false; }
  /// Which meshes have to be written anew for its readers.
  virtual TakenMeshes taken_meshes() const { return TakenMeshes::kForeign; }
  /// The file's text; what the format cannot say is in `loss`. @pre can_write()
  virtual std::string write(const RobotDescription& robot, LossReport& loss) const;
};

/// All that there are, by name.
const std::vector<std::unique_ptr<RobotFormat>>& robot_formats();

/// The format of that name. @throws geometry::InputError with the nearest one there is
const RobotFormat& format_named(const std::string& name);
/// That of a file that is there, by how it begins or its root element. @throws geometry::InputError
/// naming the formats that are read
const RobotFormat& format_of(const std::filesystem::path& file);
/// That of a file that will be written, by its ending. @throws as format_named()
const RobotFormat& format_for(const std::filesystem::path& file);

/// Meshes that are named from the folder `from` are named from `to`; what is no file there, or has
/// package:// before it, stays.
void move_meshes(RobotDescription& robot, const std::filesystem::path& from,
                 const std::filesystem::path& to);

/// Reads a file of any format. @throws geometry::InputError as format_of() and read(); also where
/// masses, places or sizes are 1e100 or more, or no numbers, after all that is made of them.
RobotDescription read_robot(const std::filesystem::path& file, LossReport& loss);

}  // namespace prehend::robot::formats
