#pragma once

namespace prehend::contact {

/// Constants of one soft contact element: linear spring-damper normal force and LuGre friction
/// (Moisio, Leon, Korkealaakso, Morales, "Model of Tactile Sensors Using Soft Contacts and its
/// Application in Robot Grasping Simulation"). The defaults are that paper's.
///   Fn = max(0, k d + c dd/dt)
///   dz/dt = v - sigma0 |v| / g(v) z,   g(v) = Fn [mu_d + (mu_s - mu_d) exp(-(v/v_s)^2)]
///   Ft = sigma0 z + sigma1 dz/dt + sigma2 v
struct TexelLaw {
  double stiffness = 1e3;           // k [N/m]
  double damping = 10;              // c [N s/m]
  double bristle_stiffness = 200;   // sigma0 [N/m]
  double bristle_damping = 0.5;     // sigma1 [N s/m]
  double viscous_friction = 0;      // sigma2 [N s/m]
  double static_friction = 0.8;     // mu_s
  double dynamic_friction = 0.7;    // mu_d <= mu_s
  double stribeck_velocity = 0.01;  // v_s [m/s], > 0
};

}  // namespace prehend::contact
