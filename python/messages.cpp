#include "python/messages.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "prehend/geometry/errors.h"
#include "prehend/recording/protobuf_schema.h"
#include "prehend/text/nearest_match.h"
#include "tools/own_message_types.h"

namespace prehend::python {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// Calls `work` with a value of the field's C++ type, for those that are numbers.
template <class Work>
auto with_number(FieldDescriptor::CppType type, Work work) {
  switch (type) {
    case FieldDescriptor::CPPTYPE_INT32:
      return work(std::int32_t{});
    case FieldDescriptor::CPPTYPE_INT64:
      return work(std::int64_t{});
    case FieldDescriptor::CPPTYPE_UINT32:
      return work(std::uint32_t{});
    case FieldDescriptor::CPPTYPE_UINT64:
      return work(std::uint64_t{});
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return work(double{});
    case FieldDescriptor::CPPTYPE_FLOAT:
      return work(float{});
    default:
      return work(bool{});
  }
}

bool is_number(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
    case FieldDescriptor::CPPTYPE_STRING:
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return false;
    default:
      return true;
  }
}

template <class Number>
Number number_of(const Reflection& reflection, const Message& message,
                 const FieldDescriptor* field) {
  if constexpr (std::is_same_v<Number, bool>) return reflection.GetBool(message, field);
  if constexpr (std::is_same_v<Number, float>) return reflection.GetFloat(message, field);
  if constexpr (std::is_same_v<Number, double>) return reflection.GetDouble(message, field);
  if constexpr (std::is_same_v<Number, std::int32_t>) return reflection.GetInt32(message, field);
  if constexpr (std::is_same_v<Number, std::int64_t>) return reflection.GetInt64(message, field);
  if constexpr (std::is_same_v<Number, std::uint32_t>) return reflection.GetUInt32(message, field);
  if constexpr (std::is_same_v<Number, std::uint64_t>) return reflection.GetUInt64(message, field);
}

template <class Number>
void set_number(const Reflection& reflection, Message* message, const FieldDescriptor* field,
                Number value) {
  if constexpr (std::is_same_v<Number, bool>) reflection.SetBool(message, field, value);
  if constexpr (std::is_same_v<Number, float>) reflection.SetFloat(message, field, value);
  if constexpr (std::is_same_v<Number, double>) reflection.SetDouble(message, field, value);
  if constexpr (std::is_same_v<Number, std::int32_t>) reflection.SetInt32(message, field, value);
  if constexpr (std::is_same_v<Number, std::int64_t>) reflection.SetInt64(message, field, value);
  if constexpr (std::is_same_v<Number, std::uint32_t>) reflection.SetUInt32(message, field, value);
  if constexpr (std::is_same_v<Number, std::uint64_t>) reflection.SetUInt64(message, field, value);
}

// --- to Python
// ------------------------------------------------------------------------------------

/// A message, and what keeps it alive for the arrays that view it.
class ToPython {
 public:
  explicit ToPython(const SharedMessage& owner)
      : owner_(new SharedMessage(owner),
               [](void* held) { delete static_cast<SharedMessage*>(held); }) {}

  py::object object(const Message& message) const {
    const Descriptor& type = *message.GetDescriptor();
    py::dict fields;
    for (int i = 0; i < type.field_count(); ++i) {
      const FieldDescriptor* field = type.field(i);
      fields[py::str(field->name())] = value(message, field);
    }
    // Kept for the process' life: it outlives the interpreter's own end.
    static const py::handle made =
        py::object(py::module_::import("prehend.messages").attr("Message")).release();
    return made(type.full_name(), std::move(fields));
  }

 private:
  py::object value(const Message& message, const FieldDescriptor* field) const {
    const Reflection& reflection = *message.GetReflection();
    if (field->is_map()) return map(message, field);
    if (field->is_repeated()) return repeated(message, field);
    if (field->has_presence() && !reflection.HasField(message, field)) return py::none();
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_MESSAGE:
        return object(reflection.GetMessage(message, field));
      case FieldDescriptor::CPPTYPE_ENUM:
        return enum_name(field, reflection.GetEnumValue(message, field));
      case FieldDescriptor::CPPTYPE_STRING:
        return string(reflection, message, field);
      default:
        return with_number(field->cpp_type(), [&](auto zero) -> py::object {
          return py::cast(number_of<decltype(zero)>(reflection, message, field));
        });
    }
  }

  /// Of a number that the type does not know: the number.
  static py::object enum_name(const FieldDescriptor* field, int number) {
    const EnumValueDescriptor* known = field->enum_type()->FindValueByNumber(number);
    if (known) return py::str(known->name());
    return py::int_(number);
  }

  static py::object text(const std::string& bytes) {
    PyObject* made =
        PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "replace");
    if (!made) throw py::error_already_set();
    return py::reinterpret_steal<py::object>(made);
  }

  py::object string(const Reflection& reflection, const Message& message,
                    const FieldDescriptor* field) const {
    std::string scratch;
    const std::string& bytes = reflection.GetStringReference(message, field, &scratch);
    if (field->type() == FieldDescriptor::TYPE_STRING) return text(bytes);
    if (&bytes == &scratch) return py::bytes(bytes);
    return view(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }

  template <class Number>
  py::object view(const Number* first, std::size_t count) const {
    py::array_t<Number> array(static_cast<py::ssize_t>(count), first, owner_);
    array.attr("setflags")(py::arg("write") = false);
    return array;
  }

  py::object repeated(const Message& message, const FieldDescriptor* field) const {
    const Reflection& reflection = *message.GetReflection();
    if (is_number(*field)) {
      return with_number(field->cpp_type(), [&](auto zero) -> py::object {
        using Number = decltype(zero);
        const auto& numbers = reflection.GetRepeatedField<Number>(message, field);
        return view(numbers.data(), static_cast<std::size_t>(numbers.size()));
      });
    }
    py::list values;
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        values.append(object(reflection.GetRepeatedMessage(message, field, i)));
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
        values.append(enum_name(field, reflection.GetRepeatedEnumValue(message, field, i)));
      } else if (field->type() == FieldDescriptor::TYPE_STRING) {
        values.append(text(reflection.GetRepeatedString(message, field, i)));
      } else {
        values.append(py::bytes(reflection.GetRepeatedString(message, field, i)));
      }
    }
    return std::move(values);
  }

  py::object map(const Message& message, const FieldDescriptor* field) const {
    const Reflection& reflection = *message.GetReflection();
    const Descriptor& entry = *field->message_type();
    py::dict values;
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      const Message& one = reflection.GetRepeatedMessage(message, field, i);
      values[value(one, entry.map_key())] = value(one, entry.map_value());
    }
    return std::move(values);
  }

  py::capsule owner_;
};

// --- from Python
// ----------------------------------------------------------------------------------

std::string name_of(const FieldDescriptor* field) {
  return field->containing_type()->name() + "." + field->name();
}

[[noreturn]] void wrong_type(const FieldDescriptor* field, const py::handle& value,
                             const char* wanted) {
  throw py::type_error(fmt::format("{} is {}; give {}", name_of(field),
                                   std::string(py::str(py::type::of(value))), wanted));
}

[[noreturn]] void out_of_range(const FieldDescriptor* field) {
  throw py::value_error(
      fmt::format("{} has a number that {} does not hold", name_of(field), field->cpp_type_name()));
}

template <class Number>
Number read_number(const FieldDescriptor* field, const py::handle& value) {
  if constexpr (std::is_same_v<Number, bool>) {
    // NumPy's bool is none of Python's.
    if (!py::isinstance<py::bool_>(value) &&
        std::string(py::str(py::type::of(value).attr("__name__"))).rfind("bool", 0) != 0) {
      wrong_type(field, value, "a bool");
    }
    return py::cast<bool>(py::bool_(py::reinterpret_borrow<py::object>(value)));
  } else if constexpr (std::is_floating_point_v<Number>) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred()) {
      PyErr_Clear();
      wrong_type(field, value, "a number");
    }
    return static_cast<Number>(number);
  } else {
    const auto whole = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
    if (!whole) {
      PyErr_Clear();
      wrong_type(field, value, "a whole number");
    }
    const bool is_signed = std::is_signed_v<Number>;
    const long long low = is_signed ? PyLong_AsLongLong(whole.ptr()) : 0;
    const unsigned long long high = is_signed ? 0 : PyLong_AsUnsignedLongLong(whole.ptr());
    if (PyErr_Occurred()) {
      PyErr_Clear();
      out_of_range(field);
    }
    if (is_signed ? (low < static_cast<long long>(std::numeric_limits<Number>::min()) ||
                     low > static_cast<long long>(std::numeric_limits<Number>::max()))
                  : high > static_cast<unsigned long long>(std::numeric_limits<Number>::max())) {
      out_of_range(field);
    }
    return is_signed ? static_cast<Number>(low) : static_cast<Number>(high);
  }
}

std::string read_bytes(const FieldDescriptor* field, const py::handle& value) {
  if (field->type() == FieldDescriptor::TYPE_STRING) {
    if (!py::isinstance<py::str>(value)) wrong_type(field, value, "a str");
    return py::cast<std::string>(value);
  }
  if (!PyObject_CheckBuffer(value.ptr())) wrong_type(field, value, "bytes or an array of uint8");
  Py_buffer buffer{};
  if (PyObject_GetBuffer(value.ptr(), &buffer, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) != 0) {
    PyErr_Clear();
    wrong_type(field, value, "bytes or an array of uint8 that lies in one piece");
  }
  const bool is_bytes = buffer.itemsize == 1;
  std::string bytes;
  if (is_bytes) {
    bytes.assign(static_cast<const char*>(buffer.buf), static_cast<std::size_t>(buffer.len));
  }
  PyBuffer_Release(&buffer);
  if (!is_bytes) wrong_type(field, value, "bytes or an array of uint8");
  return bytes;
}

int read_enum(const FieldDescriptor* field, const py::handle& value) {
  if (!py::isinstance<py::str>(value)) return read_number<std::int32_t>(field, value);
  const std::string name = py::cast<std::string>(value);
  const auto* type = field->enum_type();
  if (const EnumValueDescriptor* known = type->FindValueByName(name)) return known->number();
  std::vector<std::string> names;
  for (int i = 0; i < type->value_count(); ++i) names.push_back(type->value(i)->name());
  throw geometry::InputError(fmt::format("{} cannot be '{}'{}", name_of(field), name,
                                         text::nearest_match_hint(name, names)),
                             "Give one of: " + fmt::format("{}", fmt::join(names, ", ")));
}

void add_numbers(const FieldDescriptor* field, const py::handle& value, Message* message) {
  const py::array any = py::array::ensure(py::reinterpret_borrow<py::object>(value));
  if (!any) {
    PyErr_Clear();
    wrong_type(field, value, "an array of numbers");
  }
  if (any.size() == 0) return;
  with_number(field->cpp_type(), [&](auto zero) {
    using Number = decltype(zero);
    const char kind = any.dtype().kind();
    auto* numbers = message->GetReflection()->MutableRepeatedField<Number>(message, field);
    numbers->Reserve(numbers->size() + static_cast<int>(any.size()));
    const auto refuse = [&](const char* wanted) {
      throw py::type_error(fmt::format("{} has numbers of type {}; give {}", name_of(field),
                                       std::string(py::str(any.dtype())), wanted));
    };
    const auto add = [&](auto wide) {
      using Wide = decltype(wide);
      const auto array = py::array_t<Wide, py::array::c_style | py::array::forcecast>::ensure(any);
      if (!array) throw py::error_already_set();
      const Wide* from = array.data();
      for (py::ssize_t i = 0; i < array.size(); ++i) {
        if constexpr (std::is_integral_v<Wide> && !std::is_same_v<Wide, bool>) {
          if (!std::in_range<Number>(from[i])) out_of_range(field);
        }
        numbers->Add(static_cast<Number>(from[i]));
      }
    };
    if constexpr (std::is_same_v<Number, bool>) {
      if (kind != 'b') refuse("bool");
      add(bool{});
    } else if constexpr (std::is_floating_point_v<Number>) {
      if (kind != 'f' && kind != 'i' && kind != 'u') refuse("floating numbers");
      add(double{});
    } else {
      if (kind == 'u') {
        add(std::uint64_t{});
      } else if (kind == 'i') {
        add(std::int64_t{});
      } else {
        refuse("whole numbers");
      }
    }
  });
}

void add_repeated(const FieldDescriptor* field, const py::handle& value, Message* message) {
  if (is_number(*field)) return add_numbers(field, value, message);
  if (py::isinstance<py::str>(value) || !py::isinstance<py::iterable>(value)) {
    wrong_type(field, value, "a list");
  }
  const Reflection& reflection = *message->GetReflection();
  for (const py::handle one : py::reinterpret_borrow<py::iterable>(value)) {
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      fill_message(one, reflection.AddMessage(message, field));
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_ENUM) {
      reflection.AddEnumValue(message, field, read_enum(field, one));
    } else {
      reflection.AddString(message, field, read_bytes(field, one));
    }
  }
}

void set_one(const FieldDescriptor* field, const py::handle& value, Message* message) {
  const Reflection& reflection = *message->GetReflection();
  switch (field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return fill_message(value, reflection.MutableMessage(message, field));
    case FieldDescriptor::CPPTYPE_ENUM:
      return reflection.SetEnumValue(message, field, read_enum(field, value));
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection.SetString(message, field, read_bytes(field, value));
    default:
      with_number(field->cpp_type(), [&](auto zero) {
        using Number = decltype(zero);
        set_number<Number>(reflection, message, field, read_number<Number>(field, value));
      });
  }
}

void add_entries(const FieldDescriptor* field, const py::handle& value, Message* message) {
  if (!py::isinstance<py::dict>(value)) wrong_type(field, value, "a dict");
  const Descriptor& entry = *field->message_type();
  for (const auto& [key, one] : py::reinterpret_borrow<py::dict>(value)) {
    Message* added = message->GetReflection()->AddMessage(message, field);
    set_one(entry.map_key(), key, added);
    set_one(entry.map_value(), one, added);
  }
}

py::dict fields_of(const py::handle& value, const Descriptor& type) {
  if (py::hasattr(value, "_fields") && py::hasattr(value, "type_name")) {
    return py::dict(value.attr("_fields"));
  }
  if (!PyMapping_Check(value.ptr()) || !py::hasattr(value, "items")) {
    throw py::type_error(fmt::format("{} is to be a prehend.Message or a dict, not {}", type.name(),
                                     std::string(py::str(py::type::of(value)))));
  }
  return py::dict(py::reinterpret_borrow<py::object>(value));
}

}  // namespace

std::unique_ptr<Message> make_message(const std::string& name, const std::string& descriptor_set) {
  using Factory = recording::SchemaMessageFactory;
  static std::mutex mutex;
  static auto& factories =
      *new std::map<std::pair<std::string, std::string>, std::unique_ptr<Factory>>();
  const std::lock_guard lock(mutex);
  auto& factory = factories[{name, descriptor_set}];
  if (!factory) factory = std::make_unique<Factory>(name, descriptor_set);
  return factory->make();
}

std::unique_ptr<Message> make_own_message(const std::string& name) {
  const Descriptor* type = nullptr;
  for (const std::string package : {"", "prehend.msgs.", "prehend.msgs.graph."}) {
    if (!type) type = tools::own_message_type(package + name);
  }
  if (!type) {
    throw geometry::InputError("There is no message type '" + name + "'",
                               "Give one of prehend/msgs, as prehend.msgs.JointState");
  }
  return std::unique_ptr<Message>(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(type)->New());
}

py::object to_python(const SharedMessage& message) { return ToPython(message).object(*message); }

void fill_message(const py::handle& value, Message* message) {
  const Descriptor& type = *message->GetDescriptor();
  for (const auto& [key, one] : fields_of(value, type)) {
    const std::string name = py::cast<std::string>(py::str(key));
    const FieldDescriptor* field = type.FindFieldByName(name);
    if (!field) {
      std::vector<std::string> names;
      for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
      throw geometry::InputError(
          type.name() + " has no field '" + name + "'" + text::nearest_match_hint(name, names),
          "Give some of: " + fmt::format("{}", fmt::join(names, ", ")));
    }
    if (one.is_none()) continue;
    if (field->is_map()) {
      add_entries(field, one, message);
    } else if (field->is_repeated()) {
      add_repeated(field, one, message);
    } else {
      set_one(field, one, message);
    }
  }
}

}  // namespace prehend::python
