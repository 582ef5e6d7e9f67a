#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace prehend::grasp {

/// Every way in which a candidate can be no grasp, or none that is listed.
enum class Reason {
  kDirection,
  kWorkspace,
  kArm,
  kNothing,
  kTooWide,
  kOffCentre,
  kTable,
  kObject,
  kObstacle,
  kBottomsOut,
  kTurns,
  kFinger,
  kFewFingers,
  kFingerTable,
  kFingerObstacle,
  kFingersMeet,
  kNotClosed,
  kTooHeavy,
  kTooWeak,
  kSame,
  kRankedBelow,
  kEnough,
  kNoTime,
};
/// In words for people.
std::string to_string(Reason reason);

/// How far a candidate was from passing a filter.
struct Miss {
  enum class Quantity { kLength, kAngle, kForce, kQuality };  // m, rad, N, without unit
  Quantity quantity = Quantity::kLength;
  double value = 0;
  double limit = 0;

  double size() const { return value > limit ? value - limit : limit - value; }
};

/// "74.0 mm > 69.0 mm", "-3.2 mm < 4.0 mm".
std::string to_text(const Miss& miss);

/// Why a candidate is no grasp.
struct Refusal {
  Reason reason = Reason::kDirection;
  std::optional<Miss> miss;
};

/// What became of the candidates of one generator at one filter.
struct Rejection {
  Reason reason = Reason::kDirection;
  std::string generator;     // empty when there is only one
  int count = 0;             // > 0
  std::string nearest_miss;  // to_text() of the least miss; empty where nothing is measured
  std::optional<Miss> miss;  // the same in figures
};

/// Counts where candidates fall, and keeps how near the best of them came.
class Ledger {
 public:
  void reject(Reason reason, std::string_view generator,
              const std::optional<Miss>& miss = std::nullopt);

  /// Of all generators.
  int count(Reason reason) const;
  int total() const;
  /// In the order of `stages`, the reasons in the order in which they are tested; what is not among
  /// them after these, in the order in which it came up first.
  std::vector<Rejection> rejections(std::span<const Reason> stages = {}) const;

 private:
  struct Entry {
    Reason reason;
    std::string generator;
    int count = 0;
    std::optional<Miss> nearest;
  };
  std::vector<Entry> entries_;
};

}  // namespace prehend::grasp
