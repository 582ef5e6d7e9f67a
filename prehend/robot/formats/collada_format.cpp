// COLLADA 1.5 robots, .dae and .zae: collada_reader.h says what is read, docs/models.md what is
// written.

#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/archive.h"
#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/collada_reader.h"
#include "prehend/robot/formats/collada_shape_writer.h"
#include "prehend/robot/formats/collada_writer.h"
#include "prehend/robot/formats/extension.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;

constexpr const char* kBlock = "robot";

/// prehend's blocks, in the extras of its own type below the root.
std::vector<XmlElement> collada_blocks(const XmlElement& root) {
  std::vector<XmlElement> blocks;
  for (const XmlElement& extra : root.children("extra")) {
    if (extra.attribute("type").value_or("") != kColladaExtension) continue;
    for (const XmlElement& technique : extra.children("technique")) {
      if (technique.attribute("profile").value_or("") != kColladaExtension) continue;
      for (const XmlElement& block : technique.children(kBlock)) blocks.push_back(block);
    }
  }
  return blocks;
}

/// Meshes are within the document, without their files' names and scales: of these nothing is to be
/// told. @param plain as it is read, in the robot's order
void take_own_meshes(std::vector<Shape>& plain, const std::vector<Shape>& robot, bool is_seen,
                     const std::string& link) {
  auto read = plain.begin();
  bool is_as_written = true;
  for (const Shape& shape : robot) {
    if (!is_in_collada(shape, is_seen)) continue;
    is_as_written = is_as_written && read != plain.end() && read->kind == shape.kind;
    if (!is_as_written) break;
    if (shape.kind == Shape::Kind::kMesh) {
      read->mesh = shape.mesh;
      read->scale = shape.scale;
    }
    ++read;
  }
  if (is_as_written && read == plain.end()) return;
  throw InputError("link '" + link + "' has shapes that are read otherwise", "Mend its meshes");
}

/// Without meshes that have a surface which no file has and the document cannot have: they are
/// lost.
RobotDescription without_bad_surfaces(RobotDescription robot, LossReport& loss) {
  for (LinkDescription& link : robot.links) {
    for (const bool is_seen : {true, false}) {
      std::erase_if(is_seen ? link.visuals : link.collisions, [&](const Shape& shape) {
        const bool is_bad =
            shape.kind == Shape::Kind::kMesh && shape.surface && !is_in_collada(shape, is_seen);
        if (is_bad) {
          loss.drop("link '" + link.name + "'",
                    fmt::format("{} (mesh '{}')", is_seen ? "visual" : "collision", shape.mesh),
                    "it has no triangle, or is beyond all measure");
        }
        return is_bad;
      });
    }
  }
  return robot;
}

/// What prehend reads of a document without a block.
RobotDescription read_plainly(const std::string& text, const RobotDescription& robot) {
  LossReport unused;
  TrackedXml document(text, "robot.dae", unused);
  RobotDescription plain = read_collada(document, "");
  tree_order(plain);
  for (LinkDescription& link : plain.links) {
    const LinkDescription* its = robot.link(link.name);
    if (!its) continue;
    take_own_meshes(link.visuals, its->visuals, true, link.name);
    take_own_meshes(link.collisions, its->collisions, false, link.name);
  }
  return plain;
}

class Collada : public RobotFormat {
 public:
  std::string name() const override { return "collada"; }
  std::string ending() const override { return ".dae"; }
  bool recognises(const XmlElement& root) const override { return root.name() == "COLLADA"; }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    TrackedXml document = TrackedXml::read(file, loss);
    const XmlElement root = document.root();
    if (root.name() != "COLLADA") {
      root.fail("<" + root.name() + "> is no COLLADA", "Name a document of COLLADA 1.5");
    }
    RobotDescription robot = read_collada(document, file.stem().string());
    const auto blocks = collada_blocks(root);
    document.finish();
    tree_order(robot);
    apply_extension(blocks, robot, loss);
    return robot;
  }
  bool can_write() const override { return true; }
  TakenMeshes taken_meshes() const override { return TakenMeshes::kEmbedded; }
  std::string write(const RobotDescription& robot, LossReport& loss) const override {
    const RobotDescription kept = without_bad_surfaces(robot, loss);
    LossReport written;
    std::string text = collada_text(kept, written);
    const std::string block = extension_text(
        kept, [&] { return read_plainly(text, kept); }, written, loss);
    if (!block.empty()) {
      text.insert(text.rfind("</COLLADA>"),
                  fmt::format(" <extra type=\"{0}\">\n  <technique profile=\"{0}\">\n"
                              "   <{1}>{2}</{1}>\n  </technique>\n </extra>\n",
                              kColladaExtension, kBlock, escaped_text(block)));
    }
    return text;
  }
};

/// A zip of the document, which has its meshes within, and a manifest that names it
/// (Khronos' specification, chapter 10).
class ColladaArchive : public Collada {
 public:
  std::string name() const override { return "zae"; }
  std::string ending() const override { return ".zae"; }
  bool recognises(const XmlElement&) const override { return false; }
  bool recognises_text(std::string_view head) const override { return is_archive(head); }
  std::string write(const RobotDescription& robot, LossReport& loss) const override {
    constexpr const char* kManifest =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<dae_root>./robot.dae</dae_root>\n";
    return archive_of({{"manifest.xml", kManifest}, {"robot.dae", Collada::write(robot, loss)}});
  }
};

}  // namespace

std::unique_ptr<RobotFormat> collada_format() { return std::make_unique<Collada>(); }
std::unique_ptr<RobotFormat> collada_archive_format() { return std::make_unique<ColladaArchive>(); }

}  // namespace prehend::robot::formats
