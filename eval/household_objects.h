#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/evaluation_object.h"

namespace prehend::eval {

/// Twelve household objects as code, 4 to 24 cm: boxes, can, bottles, bowl, mug, spray bottle,
/// cone, ball, milk carton and a toy without any symmetry. Closed manifold meshes of 2 mm
/// resolution. Cost: about a second.
std::vector<EvaluationObject> household_objects();

/// The scanned objects of the folder of recordings `shared_data`/meshes that are there, in a fixed
/// order; the duck in the scale its source gives, the clown in twice its authors' (6 to 12 cm).
/// @throws geometry::InputError when there is none.
std::vector<EvaluationObject> scanned_objects(const std::filesystem::path& shared_data);

/// Every OBJ, PLY and STL mesh of a folder (metres, z up, in the order of their names).
/// @throws geometry::InputError when there is no such folder, no mesh in it, or one is not closed
/// or not 1 cm to 1 m long.
std::vector<EvaluationObject> objects_of_folder(const std::filesystem::path& folder);

/// Of a household thing of that volume [m^3], in kg.
double household_mass(double volume);

/// `mesh` moved so that it stands on z = 0 with the middle of its bounds on the z axis.
geometry::TriangleMesh standing(geometry::TriangleMesh mesh);

/// `mesh` turned onto its side (its z axis along x) and put on z = 0.
geometry::TriangleMesh lying(geometry::TriangleMesh mesh);

}  // namespace prehend::eval
