#include "prehend/robot/tactile_pad_yaml.h"

#include "prehend/robot/texel_law_yaml.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {

void read_tactile_pad(const YAML::Node& node, const std::filesystem::path& path,
                      const std::string& place, TactilePadModel& pad) {
  text::YamlMap map(node, path, place);
  map.read("rows", pad.rows);
  map.read("columns", pad.columns);
  map.read("texel_pitch", pad.texel_pitch);
  map.read("thickness", pad.thickness);
  map.read("newton_per_count", pad.newton_per_count);
  map.read("full_scale", pad.full_scale);
  const YAML::Node law = map.child("law");
  if (law.IsDefined()) read_texel_law(law, path, place + ".law", pad.law);
  map.finish();
}

}  // namespace prehend::robot
