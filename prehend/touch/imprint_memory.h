#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "prehend/touch/imprint.h"

namespace prehend::touch {

/// One of the things that a question is about.
struct Candidate {
  std::string name;
  double misfit = 0;  // at most 1: as near as the thing's own presses
};

struct Recognised {
  std::string name;                   // empty: none of those that are known
  std::string reason;                 // why none
  std::vector<Candidate> candidates;  // the likeliest first
};

/// By how many standard deviations presses may fit worse than a face's own. This and the defaults
/// of ImprintOptions' blur and contrast are what eval_shape_choice finds best, on shapes, pads and
/// presses that are used for nothing else.
inline constexpr double kImprintPatience = 3.6;

/// Recognises by their imprints the faces that it was taught, and refuses others.
///
/// Each face is a LearnedImprint. Asked about one or more presses of one face, each lying as it
/// will, the likeliest is that of the least sum of misfits. It is accepted when the presses' mean
/// excess is not more than `patience` standard deviations above that of the face's own presses,
/// each on the map of the others; the deviation is that of all faces' own presses (by medians).
class ImprintMemory {
 public:
  explicit ImprintMemory(const ImprintOptions& options = {}, double patience = kImprintPatience);

  /// Takes all presses that are known of a face; replaces what it was taught of it before.
  /// @throws std::invalid_argument without presses.
  void teach(const std::string& name, const std::vector<Imprint>& presses);
  /// The same of one that was learned already.
  void teach(const std::string& name, LearnedImprint face);
  /// False when it was not known.
  bool forget(const std::string& name);

  /// @throws std::invalid_argument without presses.
  Recognised ask(const std::vector<Imprint>& presses) const;

  /// How one press fits each face, by name. Cost: about 2 ms a face; judge() costs nothing.
  using Fits = std::map<std::string, ImprintFit>;
  Fits fits(const Imprint& press) const;
  /// The answer of ask() for presses whose fits are known, which may name other faces, too.
  /// @throws std::invalid_argument without presses, or when a face's fit is missing.
  Recognised judge(const std::vector<Fits>& presses) const;

  const std::map<std::string, LearnedImprint>& faces() const { return faces_; }

 private:
  double spread() const;  // standard deviation of own presses' excess, of all faces

  ImprintOptions options_;
  double patience_;
  std::map<std::string, LearnedImprint> faces_;
};

}  // namespace prehend::touch
