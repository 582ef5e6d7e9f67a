#pragma once

#include <string>

#include "prehend/simulation/explain.h"

namespace prehend::tools {

/// A recorded cloud, and how it is read; the words are those of `prehend plan`.
struct CloudToExplain {
  std::string file;
  double scale = 1;  // m per unit
  std::string viewpoint, up, table, split;
  std::string hand = "pg70", platform;  // whose measured chains are chosen from
  double budget = 0;                    // s of processor; 0: none
  double tolerance = 0;                 // m, mean error of the mesh; 0: none
};

/// Sees the cloud's objects, predicts their shapes and meshes, and says what became of its points,
/// what is modelled of the objects, and what is left out, with its bound.
/// @throws geometry::InputError for a cloud that cannot be read or shows no table, for options that
/// it cannot have, and as fidelity::choose_chain().
simulation::Explanation explain_cloud(const CloudToExplain& cloud);

}  // namespace prehend::tools
