#include "prehend/recording/protobuf_schema.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>

#include <set>
#include <stdexcept>

namespace prehend::recording {
namespace {

namespace pb = google::protobuf;

void add_file(const pb::FileDescriptor& file, std::set<std::string>& seen,
              pb::FileDescriptorSet& files) {
  if (!seen.insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) add_file(*file.dependency(i), seen, files);
  file.CopyTo(files.add_file());
}

}  // namespace

std::string file_descriptor_set(const pb::Descriptor& message) {
  pb::FileDescriptorSet files;
  std::set<std::string> seen;
  add_file(*message.file(), seen, files);
  return files.SerializeAsString();
}

struct SchemaMessageFactory::State {
  pb::DescriptorPool pool;
  pb::DynamicMessageFactory factory{&pool};
  const pb::Message* prototype = nullptr;
};

SchemaMessageFactory::SchemaMessageFactory(std::string_view name, std::string_view descriptor_set)
    : state_(std::make_unique<State>()) {
  const std::string full_name(name);
  pb::FileDescriptorSet files;
  if (descriptor_set.empty() ||
      !files.ParseFromArray(descriptor_set.data(), static_cast<int>(descriptor_set.size()))) {
    throw std::invalid_argument("the schema of " + full_name + " is not a FileDescriptorSet");
  }
  for (const auto& file : files.file()) {
    if (state_->pool.BuildFile(file) == nullptr) {
      throw std::invalid_argument("the schema of " + full_name + " has an unusable file " +
                                  file.name());
    }
  }
  const pb::Descriptor* descriptor = state_->pool.FindMessageTypeByName(full_name);
  if (descriptor == nullptr) {
    throw std::invalid_argument("the schema of " + full_name + " does not define it");
  }
  state_->prototype = state_->factory.GetPrototype(descriptor);
}

SchemaMessageFactory::~SchemaMessageFactory() = default;

std::unique_ptr<pb::Message> SchemaMessageFactory::make() const {
  return std::unique_ptr<pb::Message>(state_->prototype->New());
}

}  // namespace prehend::recording
