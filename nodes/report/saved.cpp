#include "nodes/report/saved.h"

#include <google/protobuf/util/json_util.h>

#include <fstream>
#include <stdexcept>
#include <string>

#include "msgs/convert/geometry.h"
#include "prehend/geometry/mesh_files.h"

namespace prehend::nodes {
namespace {

void write_json(const std::filesystem::path& file, const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  std::ofstream stream(file);
  stream << text;
  stream.close();
  if (!status.ok() || !stream) {
    throw std::runtime_error("'" + file.string() + "' cannot be written");
  }
}

}  // namespace

void save_predictions(const Collected& collected, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (const auto& [id, model] : collected.models) {
    if (!model.valid()) continue;
    const geometry::TriangleMesh mesh_W = convert::from_message(model.mesh());
    for (const char* ending : {".ply", ".obj", ".stl"}) {
      geometry::write_mesh_file(folder / ("object_" + std::to_string(id) + ending), mesh_W);
    }
  }
  for (const auto& [id, plan] : collected.plans) {
    write_json(folder / ("object_" + std::to_string(id) + "_grasps.json"), plan);
  }
}

}  // namespace prehend::nodes
