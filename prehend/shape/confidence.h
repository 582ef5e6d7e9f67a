#pragma once

#include <cstdint>
#include <filesystem>

namespace prehend::shape {

/// How the unseen side was made, from the most to the least trusted.
enum class CompletionMethod : std::uint8_t {
  kMirror = 0,      // at one or two planes of symmetry
  kRotation = 1,    // about a vertical axis
  kExtrusion = 2,   // of the seen outline down to the table
  kConvexHull = 3,  // of the seen points and their shadow on the table
  /// At a plane that was refused, where the view speaks against every other method still more.
  kRefusedMirror = 4,
};

/// "mirror", "rotation", "extrusion", "convex_hull", "refused_mirror".
inline const char* name(CompletionMethod method) {
  switch (method) {
    case CompletionMethod::kMirror:
      return "mirror";
    case CompletionMethod::kRotation:
      return "rotation";
    case CompletionMethod::kExtrusion:
      return "extrusion";
    case CompletionMethod::kConvexHull:
      return "convex_hull";
    case CompletionMethod::kRefusedMirror:
      return "refused_mirror";
  }
  return "unknown";
}

/// What is known of a completion without knowing the truth. All fractions are in [0, 1].
struct Evidence {
  CompletionMethod method = CompletionMethod::kMirror;
  /// The visibility that is violated: the vote without support and priors (symmetry.h), >= 0.
  double contradiction = 0;
  /// Fraction of the predicted points where the camera looked through.
  double contradicted = 0;
  /// s of symmetry.h: of the points that say anything, how many say yes.
  double support = 0;
  /// Fraction of the predicted points that come to lie on the seen surface.
  double coincident = 0;
  /// Fraction of the predicted points of which the view says nothing: beside the image.
  double unseen = 0;
  /// Vote of the second best distinct facing plane less the best one's, in [0, 1]; 1 without one.
  double margin = 1;
  /// Mean depth of the seen points within their convex hull, along the view, over the extent:
  /// 0 for what bulges, about 0.2 for a cup looked into.
  double concavity = 0;
  /// Fraction of the seen points that lie in a hollow open to above: a vessel's inside.
  double open_top = 0;
  bool cut_by_image = false;  // the image's border cuts it, or what was looked at at most
  double occluded = 0;        // share of the mask's outline where something nearer cuts it off
  bool on_another = false;    // it stands on another object, of which less is known than of a table
  /// Mean distance of the prediction by the next plane that faces the viewer and votes nearly as
  /// well to this one's [m]; 0 without one.
  double disagreement = 0;
  double guessed_depth = 0;     // mean depth of the predicted points behind the seen surface [m]
  bool may_be_several = false;  // it has a step as two things of one colour have

  /// Much of what was seen is the inside of a vessel, whose outside and floor are mostly guessed.
  bool open_vessel() const { return open_top > 0.08; }
};

/// Coefficients of the map from evidence to confidence; every one >= 0, so that the map is monotone
/// in each feature. The one place where they live: these defaults, or a file that replaces them.
struct ConfidenceModel {
  // To begin with, by method: log-odds of evidence that is perfect otherwise.
  double mirror = 4.33;
  double rotation = 3.80;
  double extrusion = 2.34;
  double convex_hull = 2.24;
  double refused_mirror = 2.14;
  // Taken off.
  double contradiction = 0.00;   // times the root of Evidence::contradiction, at most 1
  double contradicted = 5.69;    // times the root of Evidence::contradicted
  double unsupported = 2.32;     // times 1 - support
  double unseen = 1.01;          // times Evidence::unseen
  double ambiguous = 0.00;       // times 1 - margin
  double concavity = 12.88;      // times Evidence::concavity
  double open_vessel = 0.00;     // when the object is an open vessel
  double cut_by_image = 1.93;    // when it is
  double occluded = 3.11;        // times the root of Evidence::occluded
  double on_another = 2.78;      // when it is
  double disagreement = 0.00;    // times Evidence::disagreement / 5 mm, at most 1
  double guessed_depth = 0.00;   // times Evidence::guessed_depth / 0.1 m
  double may_be_several = 2.54;  // when it is

  bool operator==(const ConfidenceModel&) const = default;
};

/// Probability that the completion is right: its predicted points lie within 5 mm of the object's
/// surface on average, and the solid they enclose is the object.
///
///     confidence = 1 / (1 + exp(-x)),
///     x = (method's coefficient) - contradiction sqrt(min(1, e.contradiction))
///         - contradicted sqrt(e.contradicted) - unsupported (1 - e.support) - unseen e.unseen
///         - ambiguous (1 - e.margin) - concavity e.concavity
///         - open_vessel [e.open_vessel()] - cut_by_image [e.cut_by_image]
///         - occluded sqrt(e.occluded) - on_another [e.on_another]
///         - disagreement min(1, e.disagreement / 5 mm) - guessed_depth e.guessed_depth / 0.1 m
///         - may_be_several [e.may_be_several]
///
/// Roots, because the step from nothing to 1 % that speaks against it says more than from 10 to 11
/// %. In (0, 1); never rises when evidence gets worse.
double confidence(const Evidence& evidence, const ConfidenceModel& model = {});

/// A model from a YAML map of the names above; what is absent keeps its default.
/// @throws geometry::InputError for a file that cannot be read, an unknown name, or a coefficient
/// that is not a number or negative where it must not be.
ConfidenceModel read_confidence_model(const std::filesystem::path& path);

}  // namespace prehend::shape
