#include "prehend/graph/schema.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <map>
#include <mutex>
#include <set>
#include <stdexcept>

namespace prehend::graph {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::FileDescriptor;

// Writes the structure of a message type and all it reaches, each type once, in field order.
class StructureText {
 public:
  std::string of(const Descriptor& descriptor) {
    message(descriptor);
    return text_;
  }

 private:
  void message(const Descriptor& descriptor) {
    if (!seen_.insert(descriptor.full_name()).second) return;
    text_ += "message " + descriptor.full_name() + "{";
    std::map<int, const FieldDescriptor*> fields;
    for (int i = 0; i < descriptor.field_count(); ++i) {
      fields[descriptor.field(i)->number()] = descriptor.field(i);
    }
    for (const auto& [number, field] : fields) {
      text_ += std::to_string(number) + " " + field->name() + " " + std::to_string(field->type()) +
               (field->is_repeated() ? "*" : "") + ";";
      if (field->message_type()) text_ += field->message_type()->full_name() + ";";
      if (field->enum_type()) text_ += field->enum_type()->full_name() + ";";
    }
    text_ += "}";
    for (const auto& [number, field] : fields) {
      if (field->message_type()) message(*field->message_type());
      if (field->enum_type()) enumeration(*field->enum_type());
    }
  }

  void enumeration(const EnumDescriptor& descriptor) {
    if (!seen_.insert(descriptor.full_name()).second) return;
    text_ += "enum " + descriptor.full_name() + "{";
    for (int i = 0; i < descriptor.value_count(); ++i) {
      text_ +=
          std::to_string(descriptor.value(i)->number()) + " " + descriptor.value(i)->name() + ";";
    }
    text_ += "}";
  }

  std::string text_;
  std::set<std::string> seen_;
};

std::uint64_t fnv1a(const std::string& text) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const unsigned char c : text) hash = (hash ^ c) * 1099511628211ull;
  return hash == 0 ? 1 : hash;  // 0 means "any type" on the wire
}

void add_file(const FileDescriptor& file, std::set<std::string>& seen,
              google::protobuf::FileDescriptorSet& set) {
  if (!seen.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_file(*file.dependency(i), seen, set);
  file.CopyTo(set.add_file());
}

std::shared_ptr<const Schema> make_schema(const Descriptor& descriptor) {
  auto schema = std::make_shared<Schema>();
  schema->name = descriptor.full_name();
  schema->hash = fnv1a(StructureText().of(descriptor));
  google::protobuf::FileDescriptorSet set;
  std::set<std::string> seen;
  add_file(*descriptor.file(), seen, set);
  schema->descriptor_set = set.SerializeAsString();
  return schema;
}

}  // namespace

std::shared_ptr<const Schema> schema_of(const Descriptor& descriptor) {
  static std::mutex mutex;
  static std::map<const Descriptor*, std::shared_ptr<const Schema>> schemas;
  const std::lock_guard lock(mutex);
  auto& schema = schemas[&descriptor];
  if (!schema) schema = make_schema(descriptor);
  return schema;
}

std::shared_ptr<const Schema> schema_from_descriptor_set(const std::string& name,
                                                         const std::string& descriptor_set) {
  google::protobuf::FileDescriptorSet set;
  if (!set.ParseFromString(descriptor_set)) {
    throw std::invalid_argument("schema of '" + name + "': not a FileDescriptorSet");
  }
  google::protobuf::DescriptorPool pool;
  for (const auto& file : set.file()) {
    if (!pool.BuildFile(file)) {
      throw std::invalid_argument("schema of '" + name + "': file '" + file.name() +
                                  "' is damaged or comes before one it imports");
    }
  }
  const Descriptor* descriptor = pool.FindMessageTypeByName(name);
  if (!descriptor) {
    throw std::invalid_argument("schema of '" + name + "': the descriptor set lacks that message");
  }
  return make_schema(*descriptor);
}

}  // namespace prehend::graph
