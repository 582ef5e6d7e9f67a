#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace prehend::tools {

/// Where a value stands in a message: field numbers and indexes of repeated fields, from outside
/// in.
using FieldPlace = std::vector<int>;

/// Calls `visit` for every scalar that the message holds, also inside of its parts, in the order of
/// the fields: with its place, its name ("header.stamp", "intensity[3]") and its value as text
/// (integers and floating point so that they come back exactly, enumerations by name). Fields
/// without presence count as set. Bytes count by their size alone ("data.size"); of repeated fields
/// the first 1000 values are visited.
void visit_scalars(const google::protobuf::Message& message,
                   const std::function<void(const FieldPlace& place, const std::string& name,
                                            std::string value)>& visit);

/// The columns of a table of messages of one type, and their rows as CSV (RFC 4180).
class FieldColumns {
 public:
  /// Makes sure that there is a column for everything in the message.
  void add(const google::protobuf::Message& message);
  /// The names, each after a comma.
  std::string header() const;
  /// The message's values, each after a comma; empty where it has none.
  std::string row(const google::protobuf::Message& message) const;

 private:
  std::map<FieldPlace, std::string> names_;
};

}  // namespace prehend::tools
