#include "prehend/geometry/cloud_files.h"

#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/file_headers.h"

namespace prehend::geometry {
namespace {

const pcl::PCLPointField* find_field(const pcl::PCLPointCloud2& blob, const std::string& name) {
  for (const pcl::PCLPointField& field : blob.fields) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

template <typename T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

double load_number(const std::uint8_t* record, const pcl::PCLPointField& field) {
  const std::uint8_t* bytes = record + field.offset;
  switch (field.datatype) {
    case pcl::PCLPointField::INT8:
      return load<std::int8_t>(bytes);
    case pcl::PCLPointField::UINT8:
      return load<std::uint8_t>(bytes);
    case pcl::PCLPointField::INT16:
      return load<std::int16_t>(bytes);
    case pcl::PCLPointField::UINT16:
      return load<std::uint16_t>(bytes);
    case pcl::PCLPointField::INT32:
      return load<std::int32_t>(bytes);
    case pcl::PCLPointField::UINT32:
      return load<std::uint32_t>(bytes);
    case pcl::PCLPointField::FLOAT32:
      return load<float>(bytes);
    case pcl::PCLPointField::FLOAT64:
      return load<double>(bytes);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

std::size_t datatype_bytes(std::uint8_t datatype) {
  switch (datatype) {
    case pcl::PCLPointField::INT16:
    case pcl::PCLPointField::UINT16:
      return 2;
    case pcl::PCLPointField::INT32:
    case pcl::PCLPointField::UINT32:
    case pcl::PCLPointField::FLOAT32:
      return 4;
    case pcl::PCLPointField::FLOAT64:
      return 8;
    default:
      return 1;
  }
}

// What PCL made must be as long as it says, whatever the file did to it.
void check_blob(const pcl::PCLPointCloud2& blob, const std::filesystem::path& path) {
  const std::size_t points = std::size_t{blob.width} * blob.height;
  bool consistent = points > 0 && blob.data.size() >= points * blob.point_step;
  for (const pcl::PCLPointField& field : blob.fields) {
    consistent = consistent && field.offset + datatype_bytes(field.datatype) <= blob.point_step;
  }
  for (const char* name : {"x", "y", "z"}) consistent = consistent && find_field(blob, name);
  if (!consistent) {
    throw InputError("'" + path.string() + "' could not be read as a cloud",
                     "Copy or record the file again");
  }
}

std::vector<Eigen::Vector3f> load_vectors(const pcl::PCLPointCloud2& blob,
                                          const std::array<const char*, 3>& names) {
  std::array<const pcl::PCLPointField*, 3> fields{};
  for (std::size_t k = 0; k < 3; ++k) {
    fields[k] = find_field(blob, names[k]);
    if (fields[k] == nullptr) return {};
  }
  std::vector<Eigen::Vector3f> vectors(std::size_t{blob.width} * blob.height);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const std::uint8_t* record = blob.data.data() + i * blob.point_step;
    for (int k = 0; k < 3; ++k) {
      vectors[i][k] = static_cast<float>(load_number(record, *fields[k]));
    }
  }
  return vectors;
}

// PCL's packed colour 0xAARRGGBB, as integer or in the bits of a float.
std::vector<Rgb> load_colors(const pcl::PCLPointCloud2& blob) {
  const pcl::PCLPointField* field = find_field(blob, "rgb");
  if (field == nullptr) field = find_field(blob, "rgba");
  if (field == nullptr || datatype_bytes(field->datatype) != 4) return {};
  std::vector<Rgb> colors(std::size_t{blob.width} * blob.height);
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const auto packed = load<std::uint32_t>(blob.data.data() + i * blob.point_step + field->offset);
    colors[i] = {static_cast<std::uint8_t>(packed >> 16), static_cast<std::uint8_t>(packed >> 8),
                 static_cast<std::uint8_t>(packed)};
  }
  return colors;
}

void load_labels(const pcl::PCLPointCloud2& blob, CloudFile& file) {
  const pcl::PCLPointField* field = find_field(blob, "label");
  if (field == nullptr) return;
  file.has_labels = true;
  file.labels.resize(std::size_t{blob.width} * blob.height);
  for (std::size_t i = 0; i < file.labels.size(); ++i) {
    const double value = load_number(blob.data.data() + i * blob.point_step, *field);
    file.labels[i] = value > 0 && value <= 4294967295.0 ? static_cast<std::uint32_t>(value) : 0;
  }
}

CloudFile from_blob(const pcl::PCLPointCloud2& blob) {
  CloudFile file;
  PointCloud& cloud = file.cloud;
  cloud.points = load_vectors(blob, {"x", "y", "z"});
  for (Eigen::Vector3f& point : cloud.points) {
    if (!point.allFinite()) point.setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  cloud.normals = load_vectors(blob, {"normal_x", "normal_y", "normal_z"});
  cloud.colors = load_colors(blob);
  if (blob.height > 1) {
    cloud.width = static_cast<int>(blob.width);
    cloud.height = static_cast<int>(blob.height);
  }
  load_labels(blob, file);
  return file;
}

void add_field(pcl::PCLPointCloud2& blob, const std::string& name) {
  pcl::PCLPointField field;
  field.name = name;
  field.offset = blob.point_step;
  field.datatype = pcl::PCLPointField::FLOAT32;
  field.count = 1;
  blob.fields.push_back(field);
  blob.point_step += 4;
}

pcl::PCLPointCloud2 to_blob(const PointCloud& cloud) {
  pcl::PCLPointCloud2 blob;
  const bool colored = cloud.colors.size() == cloud.size();
  const bool with_normals = cloud.normals.size() == cloud.size();
  for (const char* name : {"x", "y", "z"}) add_field(blob, name);
  if (colored) add_field(blob, "rgb");
  if (with_normals) {
    for (const char* name : {"normal_x", "normal_y", "normal_z"}) add_field(blob, name);
  }
  blob.width = static_cast<std::uint32_t>(cloud.organized() ? cloud.width : cloud.size());
  blob.height = static_cast<std::uint32_t>(cloud.organized() ? cloud.height : 1);
  blob.row_step = blob.point_step * blob.width;
  blob.data.resize(cloud.size() * blob.point_step);
  std::uint8_t* bytes = blob.data.data();
  const auto append = [&bytes](const void* source, std::size_t size) {
    std::memcpy(bytes, source, size);
    bytes += size;
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    append(cloud.points[i].data(), 12);
    if (colored) {
      const Rgb& c = cloud.colors[i];
      const std::uint32_t packed = 0xff000000U | (std::uint32_t{c[0]} << 16) |
                                   (std::uint32_t{c[1]} << 8) | std::uint32_t{c[2]};
      append(&packed, 4);
    }
    if (with_normals) append(cloud.normals[i].data(), 12);
  }
  return blob;
}

}  // namespace

CloudFile read_cloud_file(const std::filesystem::path& path) {
  // PCL would print its own account; the exception carries ours.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  checked_file_size(path);
  const std::string extension = lower_case_extension(path);
  if (extension != ".pcd" && extension != ".ply") {
    throw InputError("'" + path.string() + "' is neither a .pcd nor a .ply file",
                     "Convert it, e.g. with CloudCompare");
  }
  std::optional<RigidTransform> viewpoint;
  bool viewpoint_by_pcl = false;
  std::size_t promised = 0;
  if (extension == ".pcd") {
    const PcdHeader header = read_pcd_header(path);
    viewpoint = header.viewpoint;
    promised = header.points;
  } else {
    const PlyHeader header = read_ply_header(path);
    viewpoint_by_pcl = header.has_camera;
    promised = header.vertices;
  }
  pcl::PCLPointCloud2 blob;
  Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
  int version = 0;
  std::string reason;
  try {
    const int status =
        extension == ".pcd"
            ? pcl::PCDReader().read(path.string(), blob, origin, orientation, version)
            : pcl::PLYReader().read(path.string(), blob, origin, orientation, version);
    if (status < 0) reason = "its data could not be decoded";
  } catch (const std::exception& error) {
    reason = error.what();
  }
  if (reason.empty() && std::size_t{blob.width} * blob.height != promised) {
    reason = std::to_string(std::size_t{blob.width} * blob.height) + " of " +
             std::to_string(promised) + " points could be read";
  }
  if (!reason.empty()) {
    throw InputError("'" + path.string() + "' is damaged: " + reason,
                     "Copy or record the file again");
  }
  check_blob(blob, path);
  CloudFile file = from_blob(blob);
  file.viewpoint = viewpoint;
  const Eigen::Quaterniond q = orientation.cast<double>();
  if (viewpoint_by_pcl && q.coeffs().allFinite() && q.norm() > 1e-6 && origin.allFinite()) {
    file.viewpoint = make_transform(q, origin.head<3>().cast<double>());
  }
  return file;
}

void write_cloud_file(const std::filesystem::path& path, const PointCloud& cloud,
                      const RigidTransform& viewpoint) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  const std::string extension = lower_case_extension(path);
  if (extension != ".pcd" && extension != ".ply") {
    throw InputError("'" + path.string() + "' is neither a .pcd nor a .ply name",
                     "Choose one of these endings");
  }
  if (cloud.empty()) {
    throw InputError("The cloud for '" + path.string() + "' is empty", "Write one with points");
  }
  const pcl::PCLPointCloud2 blob = to_blob(cloud);
  Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  origin.head<3>() = viewpoint.translation().cast<float>();
  const Eigen::Quaternionf orientation(viewpoint.linear().cast<float>());
  std::string reason;
  try {
    const int status = extension == ".pcd"
                           ? pcl::PCDWriter().writeBinary(path.string(), blob, origin, orientation)
                           : pcl::PLYWriter().writeBinary(path.string(), blob, origin, orientation);
    if (status < 0) reason = "PCL refused";
  } catch (const std::exception& error) {
    reason = error.what();
  }
  if (!reason.empty()) {
    throw InputError("'" + path.string() + "' could not be written: " + reason,
                     "Check that the folder exists, is writable and has space");
  }
}

}  // namespace prehend::geometry
