#pragma once

#include <string>

class SoCallbackAction;
class SoNode;

// What Coin 4 does not bear: it takes every index of a file for one that is there, and makes some
// shapes by a display's OpenGL. Internal to inventor_mesh.
namespace prehend::robot::formats {

/// Whether a node has no part in a surface's places: normals, colours and textures, whose indices
/// would be taken for true, too; and shapes of lines and points.
bool is_no_surface(const SoNode& node);

/// Looks over a shape, in the state that it is met in, before Coin makes triangles of it; takes
/// normals, colours and textures of its own out of it.
/// @returns what is wrong with it: indices or counts beyond its points, or a kind of which Coin
/// makes triangles only where there is a display (NURBS, texts); empty: nothing
std::string wrong_with_shape(SoCallbackAction& action, SoNode& shape);

}  // namespace prehend::robot::formats
