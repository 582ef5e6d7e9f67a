#pragma once

#include <string>

struct ddsi_serdata;
struct ddsi_sertype;

namespace prehend::drivers::ros_link {

/// A type of CycloneDDS whose samples are their own bytes: XCDR version 1 with its header of four.
/// Its name alone is told to peers, as ROS 2's own do that have no type information.
/// @returns one reference, which dds_create_topic_sertype() takes.
ddsi_sertype* new_bytes_type(const std::string& dds_name);

/// A sample of that type for dds_writecdr(), which takes it.
ddsi_serdata* new_sample(const ddsi_sertype& type, std::string bytes);
/// Bytes of a sample that dds_takecdr() gave.
const std::string& bytes_of(const ddsi_serdata& sample);

}  // namespace prehend::drivers::ros_link
