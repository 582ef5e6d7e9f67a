#include "drivers/ros/transport/dds_types.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

// The interface between CycloneDDS and a representation of samples (dds/ddsi/ddsi_sertype.h,
// ddsi_serdata.h), for one that is bytes and has no key.
namespace prehend::drivers::ros_link {
namespace {

struct Sample : ddsi_serdata {
  std::string bytes;
};

const Sample& sample_of(const ddsi_serdata* data) { return *static_cast<const Sample*>(data); }

std::uint32_t hash_of(const char* text) {  // FNV-1a
  std::uint32_t hash = 2166136261U;
  for (; *text != '\0'; ++text) hash = (hash ^ static_cast<unsigned char>(*text)) * 16777619U;
  return hash;
}

Sample* make(const ddsi_sertype* type, ddsi_serdata_kind kind, std::string bytes) {
  auto* sample = new Sample;
  ddsi_serdata_init(sample, type, kind);
  sample->hash = hash_of(type->type_name);
  sample->bytes = std::move(bytes);
  // Up to three bytes beyond the end are sent, too: they are there, and zeros.
  sample->bytes.append(3, '\0');
  sample->bytes.resize(sample->bytes.size() - 3);
  return sample;
}

// Without a key all samples are of one instance.
bool same_key(const ddsi_serdata*, const ddsi_serdata*) { return true; }
std::uint32_t size(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(sample_of(data).bytes.size());
}
// Fragments may overlap.
ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind,
                             const nn_rdata* fragment, std::size_t size) {
  std::string bytes(size, '\0');
  std::size_t filled = 0;
  for (; fragment && filled < size; fragment = fragment->nextfrag) {
    const std::size_t end = std::min<std::size_t>(fragment->maxp1, size);
    if (end <= filled || fragment->min > filled) continue;
    const unsigned char* payload =
        NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    std::memcpy(&bytes[filled], payload + (filled - fragment->min), end - filled);
    filled = end;
  }
  return filled == size ? make(type, kind, std::move(bytes)) : nullptr;
}
ddsi_serdata* from_parts(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                         const ddsrt_iovec_t* parts, std::size_t size) {
  std::string bytes;
  bytes.reserve(size);
  for (std::size_t i = 0; i < count && bytes.size() < size; ++i) {
    bytes.append(static_cast<const char*>(parts[i].iov_base),
                 std::min<std::size_t>(parts[i].iov_len, size - bytes.size()));
  }
  return bytes.size() == size ? make(type, kind, std::move(bytes)) : nullptr;
}
ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return make(type, SDK_KEY, {});
}
// For writers with dds_write(): their samples are std::string.
ddsi_serdata* from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
  return make(type, kind,
              kind == SDK_DATA ? *static_cast<const std::string*>(sample) : std::string());
}
// Up to three bytes beyond the end may be asked for.
void copy_out(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* to) {
  const std::string& bytes = sample_of(data).bytes;
  const std::size_t there =
      offset < bytes.size() ? std::min(size, bytes.size() - offset) : std::size_t{0};
  std::memcpy(to, bytes.data() + std::min(offset, bytes.size()), there);
  std::memset(static_cast<char*>(to) + there, 0, size - there);
}
ddsi_serdata* refer(const ddsi_serdata* data, std::size_t offset, std::size_t size,
                    ddsrt_iovec_t* to) {
  to->iov_base = const_cast<char*>(sample_of(data).bytes.data() + offset);  // NOLINT: is only read
  to->iov_len = size;
  return ddsi_serdata_ref(data);
}
void unrefer(ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); }
bool to_sample(const ddsi_serdata* data, void* sample, void**, void*) {
  *static_cast<std::string*>(sample) = sample_of(data).bytes;
  return true;
}
ddsi_serdata* to_untyped(const ddsi_serdata* data) {
  Sample* key = make(data->type, SDK_KEY, {});
  key->type = nullptr;
  return key;
}
bool untyped_to_sample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) {
  return true;
}
void free_sample(ddsi_serdata* data) { delete static_cast<Sample*>(data); }
std::size_t print(const ddsi_sertype* type, const ddsi_serdata* data, char* to, std::size_t size) {
  return static_cast<std::size_t>(
      std::snprintf(to, size, "%s: %zu bytes", type->type_name, sample_of(data).bytes.size()));
}
void keyhash(const ddsi_serdata*, ddsi_keyhash* to, bool) { std::memset(to, 0, sizeof *to); }

const ddsi_serdata_ops kSampleOperations = [] {
  ddsi_serdata_ops operations{};
  operations.eqkey = same_key;
  operations.get_size = size;
  operations.from_ser = from_fragments;
  operations.from_ser_iov = from_parts;
  operations.from_keyhash = from_keyhash;
  operations.from_sample = from_sample;
  operations.to_ser = copy_out;
  operations.to_ser_ref = refer;
  operations.to_ser_unref = unrefer;
  operations.to_sample = to_sample;
  operations.to_untyped = to_untyped;
  operations.untyped_to_sample = untyped_to_sample;
  operations.free = free_sample;
  operations.print = print;
  operations.get_keyhash = keyhash;
  return operations;
}();

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete type;
}
void zero_samples(const ddsi_sertype*, void*, std::size_t) {}
void no_samples(void** to, const ddsi_sertype*, void*, std::size_t, std::size_t) { *to = nullptr; }
void no_free(const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {}
bool equal_types(const ddsi_sertype*, const ddsi_sertype*) { return true; }  // besides the names
std::uint32_t hash_type(const ddsi_sertype*) { return 0; }

const ddsi_sertype_ops kTypeOperations = [] {
  ddsi_sertype_ops operations{};
  operations.version = ddsi_sertype_v0;
  operations.free = free_type;
  operations.zero_samples = zero_samples;
  operations.realloc_samples = no_samples;
  operations.free_samples = no_free;
  operations.equal = equal_types;
  operations.hash = hash_type;
  return operations;
}();

}  // namespace

ddsi_sertype* new_bytes_type(const std::string& dds_name) {
  auto* type = new ddsi_sertype{};
  ddsi_sertype_init_flags(type, dds_name.c_str(), &kTypeOperations, &kSampleOperations,
                          DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

ddsi_serdata* new_sample(const ddsi_sertype& type, std::string bytes) {
  return make(&type, SDK_DATA, std::move(bytes));
}

const std::string& bytes_of(const ddsi_serdata& sample) { return sample_of(&sample).bytes; }

}  // namespace prehend::drivers::ros_link
