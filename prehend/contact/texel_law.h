#pragma once

#include <memory>
#include <vector>

namespace prehend::contact {

class CompressionCurve;

enum class NormalLaw {
  kLinear,        // Fn = max(0, k d + c dd/dt): the soft-contact paper
  kHuntCrossley,  // Fn = max(0, d^n (k + c dd/dt)): no force jump at touch-down
  kTabulated      // Fn = max(0, curve(d) + c dd/dt): foam as measured
};

enum class BristleLaw {
  kLuGre,         // dz/dt = v - sigma0 |v| / g(v) z
  kElastoPlastic  // the same times alpha(z, v): 0 below elastic_limit, hence no creep
};

/// What a foam remembers of how it was pressed, as elements in parallel to the texel's own law.
/// Each is a linear spring of `share` times memory_stiffness(law) behind a dashpot (creep) or a dry
/// slider (hysteresis), hence passive:
///   dq/dt + q / time = share k dd/dt      Prony series: generalised Maxwell model (Ferry,
///                                         "Viscoelastic Properties of Polymers", 1980, chapter 3)
///   q = share k e, |e| <= depth           Maxwell-slip (Iwan, "A Distributed-Element Model for
///                                         Hysteresis", Journal of Applied Mechanics 1966)
/// The law itself is the force in the long run, without hysteresis: held at one depth a pad that
/// was pressed at once presses with k d (1 + sum share exp(-t / time)). Loops of the sliders close
/// (return-point memory) and lose their area.
struct FoamMemory {
  struct Creep {
    double share = 0;  // of the stiffness in the long run
    double time = 0;   // s
    bool operator==(const Creep&) const = default;
  };
  struct Hysteresis {
    double share = 0;  // of the stiffness in the long run
    double depth = 0;  // m, compression at which the slider gives way
    bool operator==(const Hysteresis&) const = default;
  };
  static constexpr int kMostTerms = 8;  // of both together
  std::vector<Creep> creep;
  std::vector<Hysteresis> hysteresis;

  int terms() const { return static_cast<int>(creep.size() + hysteresis.size()); }
  bool operator==(const FoamMemory&) const = default;

  /// A pad's foam as estimated: 6 % creep in 10 s, loops of some per cent of the force. The
  /// soft-contact paper names hysteresis and creep of real pads without figures: `prehend calibrate
  /// tactile` finds those of yours.
  static FoamMemory realistic();
};

/// Constants of one soft contact element (texel) of reference area: normal spring-damper and LuGre
/// friction (Moisio, Leon, Korkealaakso, Morales, "Model of Tactile Sensors Using Soft Contacts and
/// its Application in Robot Grasping Simulation"). Stiffness, damping and bristle are those of its
/// Table I by default; its friction is 0.9 and 0.6, its foam 5 mm thick.
///   Fn = max(0, k d + c dd/dt)
///   dz/dt = v - sigma0 |v| / g(v) z,   g(v) = Fn [mu_d + (mu_s - mu_d) exp(-(v/v_s)^2)]
///   Ft = sigma0 z + sigma1 dz/dt + sigma2 v
/// Options mend what is known of the law; off, they leave the paper's law.
struct TexelLaw {
  double stiffness = 1e3;           // k [N/m]; kHuntCrossley: [N/m^n]; kTabulated: not used
  double damping = 10;              // c [N s/m]; kHuntCrossley: [N s/m^(n+1)]
  double bristle_stiffness = 200;   // sigma0 [N/m]
  double bristle_damping = 0.5;     // sigma1 [N s/m]
  double viscous_friction = 0;      // sigma2 [N s/m]
  double static_friction = 0.8;     // mu_s
  double dynamic_friction = 0.7;    // mu_d <= mu_s
  double stribeck_velocity = 0.01;  // v_s [m/s], > 0

  NormalLaw normal_law = NormalLaw::kLinear;
  double exponent = 1.5;  // n of kHuntCrossley, 1 to 4 (Hunt and Crossley 1975: 3/2 for spheres)
  std::shared_ptr<const CompressionCurve> curve;  // of kTabulated
  FoamMemory memory;  // of kLinear and kTabulated: creep and hysteresis of the normal force

  BristleLaw bristle_law = BristleLaw::kLuGre;
  /// Share of the steady bristle length g / sigma0 up to which kElastoPlastic is elastic, in
  /// [0, 1): z_ba / z_ss of Dupont, Hayward, Armstrong, Altpeter, "Single State Elastoplastic
  /// Friction Models", IEEE TAC 2002.
  double elastic_limit = 0.9;
  /// Cuts the bristle to sigma0 |z| <= mu_s Fn. The paper's law keeps a longer one when a contact
  /// is unloaded without sliding.
  bool return_map = false;
};

}  // namespace prehend::contact
