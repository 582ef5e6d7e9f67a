#pragma once

#include <filesystem>
#include <string>

namespace google::protobuf {
class Message;
}

namespace prehend::tools {

/// Writes what can be looked at in a decoded message to files whose names begin with `stem`:
/// StereoPair as STEM_left.png and STEM_right.png, the depth of ObjectHypotheses as
/// STEM_depth.png (16 bits, 0.1 mm), every PointCloud, wherever it is, as STEM[_FIELD].pcd. Returns
/// the number of files. Throws std::runtime_error naming the field when its sizes do not fit or a
/// file cannot be written.
int write_pictures(const google::protobuf::Message& message, const std::filesystem::path& stem);

}  // namespace prehend::tools
