#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prehend/grasp/generators/generator.h"
#include "prehend/text/plug_ins.h"

namespace prehend::grasp {

/// Generators by name: those that are built in, each with its source below, and each plug-in in the
/// folders of PREHEND_GENERATORS and in ../lib/prehend/generators beside the running program
/// (text::plug_in_folders()).
/// - "circles": sample_candidates() in candidates.h: two circles of approach directions round the
///   centroid (Bohg et al., "Mind the gap", ICRA 2011, section IV, the UJI platform).
/// - "segments": circles of approach directions round the line between two points of the surface
///   that face each other across the middle of the object (the same, the KTH platform), at several
///   stations of its longest axis.
/// - "boxes": rays from the sides of the object's box inwards; the hand approaches against the
///   surface normal where a ray hits (R. Diankov, "Automated construction of robotic manipulation
///   programs", PhD thesis, CMU 2010, section 4.1: OpenRAVE's approach rays).
/// - "antipodal": surface points by area, each with the point opposite along its normal; kept where
///   the line between them is in both friction cones (I-M. Chen and J. W. Burdick, "Finding
///   antipodal point grasps on irregularly shaped objects", IEEE T-RA 9(4), 1993).
/// - "medial_axis": balls that touch the surface at opposite sides from inside; the hand closes
///   along the line between the points of touch (Przybylski, Asfour and Dillmann, "Planning grasps
///   for robotic hands using a novel object representation based on the medial axis transform",
///   IROS 2011; balls by shrinking: Ma, Bae and Choi, "3D medial axis point approximation using
///   nearest neighbors and the normal field", The Visual Computer 28(1), 2012).
class GeneratorRegistry {
 public:
  GeneratorRegistry();
  explicit GeneratorRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const { return generators_.names(); }  // sorted
  bool has(const std::string& name) const { return generators_.has(name); }
  /// One of a plug-in is held to what it promises: its generate() throws std::runtime_error, naming
  /// it, for candidates that are no poses.
  /// @throws std::invalid_argument naming the nearest and all that there are.
  std::unique_ptr<CandidateGenerator> create(const std::string& name) const;
  const std::vector<text::PlugInProblem>& problems() const { return generators_.problems(); }

 private:
  text::NamedPlugIns<CandidateGenerator> generators_;
};

/// GeneratorRegistry().create(), which for what is built in looks at no folder.
std::unique_ptr<CandidateGenerator> make_generator(const std::string& name);

}  // namespace prehend::grasp
