#pragma once

#include <memory>
#include <string>

#include <google/protobuf/message.h>
#include <pybind11/pybind11.h>

// Between protobuf messages and prehend.Message.
namespace prehend::python {

namespace py = pybind11;

using SharedMessage = std::shared_ptr<const google::protobuf::Message>;

/// An empty message of a type that is known by its descriptor set. Types are kept for the process'
/// life; the same bytes give the same one. @throws std::invalid_argument for a damaged set.
std::unique_ptr<google::protobuf::Message> make_message(const std::string& name,
                                                        const std::string& descriptor_set);

/// An empty message of one of prehend's own types, "prehend.msgs.JointState" or "JointState".
/// @throws geometry::InputError with the nearest name.
std::unique_ptr<google::protobuf::Message> make_own_message(const std::string& name);

/// As prehend.Message: whole numbers, floating ones, bool, str; an enum's name; repeated numbers
/// and bytes as read-only arrays that view the message, which they keep alive; other repeated
/// fields as lists, maps as dicts; None for what is not set and can tell. Needs the interpreter's
/// lock.
py::object to_python(const SharedMessage& message);

/// Sets what `value`, a prehend.Message or a mapping, has of the message's fields; None leaves one
/// as it is. @throws geometry::InputError for a field that there is not, with the nearest name;
/// TypeError and ValueError naming the field.
void fill_message(const py::handle& value, google::protobuf::Message* message);

}  // namespace prehend::python
