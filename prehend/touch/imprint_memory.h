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

/// Recognises by their imprints the faces that it was taught, and refuses others.
///
/// Each face is a LearnedImprint. Asked about one or more presses of one face, each lying as it
/// will, the likeliest is that of the least sum of misfits. It is accepted when the presses' mean
/// excess is not more than `patience` standard deviations above that of the face's own presses,
/// each on the map of the others; the deviation is that of all faces' own presses (by medians).
class ImprintMemory {
 public:
  explicit ImprintMemory(const ImprintOptions& options = {}, double patience = 3.4);

  /// Takes all presses that are known of a face; replaces what it was taught of it before.
  /// @throws std::invalid_argument without presses.
  void teach(const std::string& name, const std::vector<Imprint>& presses);
  /// False when it was not known.
  bool forget(const std::string& name);

  /// @throws std::invalid_argument without presses.
  Recognised ask(const std::vector<Imprint>& presses) const;

  const std::map<std::string, LearnedImprint>& faces() const { return faces_; }

 private:
  double spread() const;  // standard deviation of own presses' excess, of all faces

  ImprintOptions options_;
  double patience_;
  std::map<std::string, LearnedImprint> faces_;
};

}  // namespace prehend::touch
