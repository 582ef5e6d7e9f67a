#include "prehend/robot/formats/mjcf_size.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/file_headers.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;

/// The product of an attribute's numbers, each 1 or more; 1 without it.
double product_of(const XmlElement& element, const char* name) {
  double product = 1;
  for (const double number : element.numbers(name, 0).value_or(std::vector<double>{})) {
    product *= std::max(1.0, std::abs(number));
  }
  return product;
}

class MjcfSizes {
 public:
  explicit MjcfSizes(const fs::path& file) : folder_(fs::absolute(file).parent_path()) {}

  void read_file(const fs::path& file) {
    files_.spend(file);
    LossReport unused;
    TrackedXml document = TrackedXml::read(file, unused);
    above_.push_back(fs::weakly_canonical(file));
    visit(document.root(), 1);
    above_.pop_back();
  }

  /// MuJoCo reads what is no file without end, and a damaged OBJ beyond its numbers.
  void refuse_unsound_assets() const {
    std::set<fs::path> looked_at;
    for (const auto& [name, place] : assets_) {
      for (const fs::path& folder : folders_) {
        for (const fs::path& path : {folder_ / folder / name, folder_ / folder / name.filename()}) {
          std::error_code error;
          if (!fs::exists(path, error) || !looked_at.insert(path).second) continue;
          if (!fs::is_regular_file(path, error)) {
            throw geometry::InputError(place + ": '" + name.string() + "' is no file",
                                       "Name a mesh or a picture");
          }
          if (geometry::lower_case_extension(path) == ".obj") geometry::read_mesh_file(path);
        }
      }
    }
  }

 private:
  void visit(const XmlElement& element, double times) {
    const std::string name = element.name();
    if (name == "include") return include(element);
    if (name == "body") bodies_ += times;
    for (const char* repeated : {"composite", "flexcomp", "replicate"}) {
      if (name != repeated) continue;
      times *= product_of(element, "count");
      bodies_ += times;
    }
    if (bodies_ > kMostMjcfBodies) {
      element.fail(fmt::format("the model has more than {} bodies", kMostMjcfBodies),
                   "No robot has so many: check the file, or split it");
    }
    const auto refuse_above = [&](double most, double number, const char* what) {
      if (number > most) {
        element.fail(fmt::format("{} of {:g} is more than {:g}", what, number, most),
                     "No robot needs so much: mend it");
      }
    };
    if (name == "hfield") {
      refuse_above(1e7, product_of(element, "nrow") * product_of(element, "ncol"), "a field");
    }
    if (name == "texture") {
      refuse_above(6e7, product_of(element, "width") * product_of(element, "height"), "a texture");
    }
    if (name == "size") {
      for (const char* count :
           {"njmax", "nconmax", "nkey", "nuserdata", "nuser_body", "nuser_jnt", "nuser_geom",
            "nuser_site", "nuser_cam", "nuser_tendon", "nuser_actuator", "nuser_sensor"}) {
        refuse_above(1e4, product_of(element, count), count);
      }
    }
    for (const char* folder : {"meshdir", "texturedir", "assetdir"}) {
      if (const auto named = element.attribute(folder)) folders_.emplace_back(*named);
    }
    if (const auto asset = element.attribute("file")) {
      assets_.emplace_back(*asset, element.place());
    }
    for (const XmlElement& child : element.children()) visit(child, times);
  }

  void include(const XmlElement& element) {
    const std::string name = element.attribute("file").value_or("");
    const fs::path path = folder_ / name;
    std::error_code error;
    if (!fs::exists(path, error)) return;  // the compiler says it
    if (!fs::is_regular_file(path, error)) element.fail("'" + name + "' is no file", "Mend it");
    constexpr std::size_t kDeepest = 32;
    const bool is_ring =
        std::find(above_.begin(), above_.end(), fs::weakly_canonical(path)) != above_.end();
    if (is_ring || above_.size() > kDeepest) {
      element.fail("'" + name + "' includes itself", "Leave one of the includes away");
    }
    read_file(path);
  }

  const fs::path folder_;  // the first file's, from which all is named
  FileBudget files_;
  std::vector<fs::path> above_, folders_{""};
  std::vector<std::pair<fs::path, std::string>> assets_;  // and their places
  double bodies_ = 0;
};

}  // namespace

void refuse_mjcf_bomb(const fs::path& file) {
  MjcfSizes sizes(file);
  sizes.read_file(file);
  sizes.refuse_unsound_assets();
}

}  // namespace prehend::robot::formats
