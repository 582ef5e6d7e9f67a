#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/tracked_xml.h"

// What a format cannot say of a robot, as one block of JSON in its files, which other programs pass
// over. docs/models.md says where it stands in each format, and what is in it: the records of
// prehend's own text, of each only what differs from what the rest of the file says.
namespace prehend::robot::formats {

/// The block's text with which a file is `robot` again; empty: the file says all of it.
/// @param read_again gives what is read of the file without the block.
/// @param written what the writer says that other programs do not get; what prehend gets by the
/// block goes into `loss` as extended, not as lost. Where the file cannot be read again (as its
/// compiler refuses it), or names are no UTF-8, there is no block, and `loss` says why.
std::string extension_text(const RobotDescription& robot,
                           const std::function<RobotDescription()>& read_again,
                           const LossReport& written, LossReport& loss);

/// The text on one line, for an attribute.
std::string on_one_line(const std::string& block);

/// Applies a block to what was read of the rest of the file.
/// @param place "FILE:LINE" of the block
/// @throws geometry::InputError with the place, the path in the block and the mend: what is no
/// JSON, another version, unknown keys, links and joints that are not there, shapes of another
/// number than the file's, and all that prehend's own text refuses
void apply_extension(const std::string& text, const std::string& place, RobotDescription& robot,
                     LossReport& loss);
/// That which stands in an XML element; none: the file is from elsewhere. @throws as above, and for
/// more than one
void apply_extension(const std::vector<XmlElement>& blocks, RobotDescription& robot,
                     LossReport& loss);

}  // namespace prehend::robot::formats
