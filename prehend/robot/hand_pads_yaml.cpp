#include "prehend/robot/hand_pads_yaml.h"

#include <array>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/robot/at_line.h"
#include "prehend/robot/mesh_shape.h"
#include "prehend/robot/pad_surface.h"
#include "prehend/robot/pose_yaml.h"
#include "prehend/robot/tactile_pad_yaml.h"
#include "prehend/robot/yaml_entries.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {
namespace {

using geometry::InputError;

class PadReader {
 public:
  PadReader(const YAML::Node& node, const std::filesystem::path& path,
            const std::filesystem::path& urdf, const std::string& name, const HandModel& hand)
      : node_(node),
        path_(path),
        urdf_(urdf),
        hand_(hand),
        place_("hand.pads." + name),
        map_(node, path, place_) {
    pad_.name = name;
  }

  HandPad read() {
    std::string link;
    map_.read("link", link);
    if (link.empty()) map_.fail("link", "is missing", "Name the link that carries the pad");
    pad_.link = at_line(map_, "link", [&] { return hand_.model.link_index(link); });
    const YAML::Node surface = map_.child("surface"), model = map_.child("pad");
    if (hand_.gripper) {
      if (surface.IsDefined()) {
        map_.fail("surface", "does not apply to a parallel gripper, whose pads are flat",
                  "Leave it out");
      }
      if (model.IsDefined())
        map_.fail("pad", "is the gripper's, whose file has it", "Leave it out");
      pad_.model = hand_.gripper->pad;
    } else if (model.IsDefined()) {
      read_tactile_pad(model, path_, place_ + ".pad", pad_.model);
      refused_at("pad", [&] { validate(pad_.model); });
    }
    if (!surface.IsDefined()) {
      read_pose_of_grid();
      map_.finish();
      return flat_pad(pad_.name, pad_.link, pad_.X_LP, pad_.model);
    }
    if (surface.IsMap()) {
      read_region(surface, model);
    } else {
      read_laid_grid(surface);
    }
    return std::move(pad_);
  }

 private:
  /// What `make` throws of a value, as an error at the line of `key`.
  template <class Make>
  auto refused_at(const std::string& key, Make make) -> decltype(make()) {
    try {
      return make();
    } catch (const std::invalid_argument& error) {
      map_.fail(key, std::string(": ") + error.what(), "Correct that value");
    }
  }

  const Link& link() const { return hand_.model.links[static_cast<std::size_t>(pad_.link)]; }

  void read_pose_of_grid() {
    Eigen::Vector3d center = Eigen::Vector3d::Zero(), normal = center, toward_tip = center;
    map_.read("center", center);
    map_.read("normal", normal);
    map_.read("toward_tip", toward_tip);
    if (!(normal.norm() > 1e-9)) map_.fail("normal", "has no length", "Give it, out of the face");
    const Eigen::Vector3d z = normal.normalized();
    const Eigen::Vector3d along = toward_tip - toward_tip.dot(z) * z;
    if (!(along.norm() > 1e-9)) {
      map_.fail("toward_tip", "does not lie in the face", "Give a direction across the normal");
    }
    const Eigen::Vector3d y = along.normalized();
    pad_.X_LP.linear() << y.cross(z), y, z;
    pad_.X_LP.translation() = center;
  }

  void read_laid_grid(const YAML::Node& surface) {
    if (!surface.IsScalar() || surface.Scalar() != "link") {
      map_.fail("surface", "is neither `link` nor a region of a mesh",
                "Write surface: link, to lay the grid on the link's shapes, surface: {mesh: FILE, "
                "group: NAME}, or leave it out for a flat pad");
    }
    read_pose_of_grid();
    const std::vector<Eigen::Vector2i> left_out = read_cells();
    double raised = 0;
    map_.read("raised", raised);
    map_.finish();
    if (!(raised >= 0 && raised <= pad_.model.thickness)) {
      map_.fail("raised",
                "is not between 0 and the foam's thickness of " +
                    std::to_string(pad_.model.thickness) + " m",
                "Give by how much the pad's face stands over the link, in m");
    }
    const contact::PadGrid grid{pad_.model.rows, pad_.model.columns, pad_.model.width(),
                                pad_.model.length(), pad_.model.thickness};
    try {
      pad_.layout = std::make_shared<const contact::PadLayout>(
          lay_on_link(link(), pad_.X_LP, grid, raised, left_out));
    } catch (const std::invalid_argument& error) {
      map_.fail("surface",
                ": the grid cannot be laid on link '" + link().name + "': " + error.what(),
                "Move `center` onto or before the link, or make the grid smaller");
    }
  }

  std::vector<Eigen::Vector2i> read_cells() {
    const YAML::Node cells = map_.child("without");
    std::vector<Eigen::Vector2i> left_out;
    if (!cells.IsDefined()) return left_out;
    const auto fail = [this] {
      map_.fail("without", "is no list of cells", "Write [[row, column], [row, column]]");
    };
    if (!cells.IsSequence()) fail();
    for (const auto& cell : cells) {
      if (!cell.IsSequence() || cell.size() != 2) fail();
      int at[2] = {0, 0};
      for (std::size_t k = 0; k < 2; ++k) {
        if (!cell[k].IsScalar() || !YAML::convert<int>::decode(cell[k], at[k])) fail();
      }
      left_out.emplace_back(at[0], at[1]);
    }
    return left_out;
  }

  void read_region(const YAML::Node& surface, const YAML::Node& model) {
    for (const char* key : {"center", "normal", "toward_tip", "without", "raised"}) {
      if (!node_[key]) continue;
      map_.child(key);
      map_.fail(key, "does not apply to a pad of a mesh, whose vertices are its cells",
                "Leave it out");
    }
    map_.finish();
    for (const char* key : {"rows", "columns", "texel_pitch"}) {
      if (!model.IsDefined() || !model[key]) continue;
      map_.fail("pad",
                std::string(".") + key +
                    " does not apply to a pad of a mesh, whose vertices are "
                    "its cells",
                "Leave it out");
    }
    text::YamlMap map(surface, path_, place_ + ".surface");
    PadRegion region = region_file(map);
    map.read("group", region.region.group);
    map.read("material", region.region.material);
    const YAML::Node painted = map.child("painted");
    map.finish();
    if (painted.IsDefined()) {
      std::array<int, 3> color{};
      bool good = painted.IsSequence() && painted.size() == 3;
      for (std::size_t k = 0; good && k < 3; ++k) {
        good = painted[k].IsScalar() && YAML::convert<int>::decode(painted[k], color[k]) &&
               color[k] >= 0 && color[k] <= 255;
      }
      if (!good) map.fail("painted", "is no colour", "Write [red, green, blue], 0 to 255 each");
      region.region.color = color;
    }
    if (!region.region.group.empty() + !region.region.material.empty() + painted.IsDefined() > 1) {
      map.fail("mesh", "names its region twice", "Write one of group, material and painted");
    }
    const contact::PadLayout cells = at_line(map_, "surface", [&] {
      return refused_at("surface", [&] { return cells_of_region(region, pad_.model.thickness); });
    });
    pad_.model.rows = 1;
    pad_.model.columns = static_cast<int>(cells.size());
    pad_.model.texel_pitch = 0;
    pad_.layout = std::make_shared<const contact::PadLayout>(cells);
  }

  /// The file that `surface` names, or that of the link's shape.
  PadRegion region_file(text::YamlMap& map) {
    PadRegion region;
    std::string mesh;
    double scale = 1;
    map.read("mesh", mesh);
    map.read("scale", scale);
    const YAML::Node origin = map.child("origin");
    if (!mesh.empty()) {
      region.file = path_.parent_path() / mesh;
      if (!(scale > 0)) map.fail("scale", "is not positive", "Give metres per unit of the file");
      region.scale.setConstant(scale);
      if (origin.IsDefined()) region.X_LS = read_pose(origin, path_, place_ + ".surface.origin");
      return region;
    }
    const CollisionShape* found = nullptr;
    for (const CollisionShape& shape : link().shapes) {
      if (shape.kind != CollisionShape::Kind::kMesh) continue;
      if (found) {
        map_.fail("surface", ": link '" + link().name + "' has several meshes",
                  "Name one by `mesh`, relative to this file");
      }
      found = &shape;
    }
    if (!found) {
      map_.fail("surface", ": link '" + link().name + "' has no mesh",
                "Name a file by `mesh`, relative to this one, or write surface: link");
    }
    for (const char* key : {"scale", "origin"}) {
      if (map.child(key).IsDefined()) {
        map.fail(key, "does not apply to the link's own mesh, whose URDF has it", "Leave it out");
      }
    }
    region.file = find_mesh_file(found->mesh, urdf_.parent_path());
    region.scale = found->size;
    region.X_LS = found->X_LS;
    return region;
  }

  const YAML::Node& node_;
  const std::filesystem::path& path_;
  const std::filesystem::path& urdf_;
  const HandModel& hand_;
  std::string place_;
  text::YamlMap map_;
  HandPad pad_;
};

}  // namespace

void read_hand_pads(const YAML::Node& node, const std::filesystem::path& path,
                    const std::filesystem::path& urdf, HandModel& hand) {
  for_each_entry(node, path, "hand.pads",
                 [&](text::YamlMap& map, const std::string& name, const YAML::Node& value) {
                   HandPad pad = PadReader(value, path, urdf, name, hand).read();
                   for (const HandPad& other : hand.pads) {
                     const std::string problem = overlap(other, pad);
                     if (problem.empty()) continue;
                     map.fail(name, ": " + problem + ", where foam would press twice",
                              "Move or shorten one of them");
                   }
                   hand.pads.push_back(std::move(pad));
                 });
}

}  // namespace prehend::robot
