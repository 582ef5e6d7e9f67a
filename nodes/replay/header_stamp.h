#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace prehend {

/// Number of the field of type prehend.msgs.Header in message `name`, 0 when it has none. Throws
/// std::invalid_argument when the descriptor set is damaged.
int header_field_of(const std::string& name, const std::string& descriptor_set);

/// [ns] header.stamp of an encoded message, found without decoding the rest; 0 when there is none.
std::int64_t header_stamp(std::string_view message, int header_field);

}  // namespace prehend
