#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "prehend/geometry/rigid_transform.h"

namespace urdf {
class ModelInterface;
class Pose;
}  // namespace urdf

// Reading URDF (http://wiki.ros.org/urdf/XML) by urdfdom, with one clear error.
namespace prehend::robot {

/// The document in `text`; `name` stands for the file in messages. Never null, with a root link.
/// @throws geometry::InputError with what the parser complains of, also when it would leave out a
/// part and go on, for macros of xacro, and for more than 64 MiB, 10,000 links, or what
/// text::refuse_xml_bomb() refuses.
std::shared_ptr<urdf::ModelInterface> parse_urdf_document(const std::string& text,
                                                          const std::string& name);

/// The same from a file. @throws geometry::InputError also when it cannot be read.
std::shared_ptr<urdf::ModelInterface> read_urdf_document(const std::filesystem::path& file);

/// A pose of the document; its quaternion is normalised.
geometry::RigidTransform to_transform(const urdf::Pose& pose);

}  // namespace prehend::robot
