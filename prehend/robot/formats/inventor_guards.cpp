#include "prehend/robot/formats/inventor_guards.h"

#include <cstdint>
#include <set>

#include <Inventor/VRMLnodes/SoVRMLCoordinate.h>
#include <Inventor/VRMLnodes/SoVRMLElevationGrid.h>
#include <Inventor/VRMLnodes/SoVRMLIndexedFaceSet.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/nodes/SoFaceSet.h>
#include <Inventor/nodes/SoIndexedFaceSet.h>
#include <Inventor/nodes/SoIndexedTriangleStripSet.h>
#include <Inventor/nodes/SoQuadMesh.h>
#include <Inventor/nodes/SoTriangleStripSet.h>
#include <Inventor/nodes/SoVertexProperty.h>

namespace prehend::robot::formats {
namespace {

constexpr const char* kBeyond = "has an index that is none of its points";

/// An index of a point, or the end of a face, which is -1.
std::string wrong_with_indices(const SoMFInt32& indices, std::int64_t points) {
  for (int i = 0; i < indices.getNum(); ++i) {
    if (indices[i] < -1 || indices[i] >= points) return kBeyond;
  }
  return {};
}

/// Points of each face or strip; a last -1 takes all that are left.
std::string wrong_with_counts(const SoMFInt32& counts, std::int64_t first, std::int64_t points) {
  if (first < 0 || first > points) return kBeyond;
  for (int i = 0; i < counts.getNum(); ++i) {
    const bool takes_rest = counts[i] == -1 && i + 1 == counts.getNum();
    const std::int64_t count = takes_rest ? points - first : counts[i];
    if (count < 3 || count > points - first) return "has a face of other points than it has";
    first += count;
  }
  return {};
}

/// Of a shape with points of its own those, without what else it has; else the state's.
std::int64_t points_of(SoVertexShape& shape, const SoCallbackAction& action) {
  SoNode* const node = shape.vertexProperty.getValue();
  if (!node || !node->isOfType(SoVertexProperty::getClassTypeId()))
    return action.getNumCoordinates();
  auto& own = *static_cast<SoVertexProperty*>(node);
  own.normal.setNum(0);
  own.orderedRGBA.setNum(0);
  own.texCoord.setNum(0);
  own.texCoord3.setNum(0);
  const std::int64_t count = own.vertex.getNum();
  return count > 0 ? count : action.getNumCoordinates();
}

std::string wrong_with_indexed(SoIndexedShape& shape, const SoCallbackAction& action) {
  shape.materialIndex.setValue(-1);
  shape.normalIndex.setValue(-1);
  shape.textureCoordIndex.setValue(-1);
  return wrong_with_indices(shape.coordIndex, points_of(shape, action));
}

std::string wrong_with_quads(SoQuadMesh& shape, const SoCallbackAction& action) {
  const std::int64_t rows = shape.verticesPerColumn.getValue(),
                     columns = shape.verticesPerRow.getValue(), first = shape.startIndex.getValue();
  const bool is_sound = rows >= 2 && columns >= 2 && first >= 0 && rows < (1 << 30) &&
                        rows * columns <= points_of(shape, action) - first;
  return is_sound ? "" : "has more rows and columns than points";
}

std::string wrong_with_vrml_faces(SoVRMLIndexedFaceSet& shape) {
  shape.normal.setValue(nullptr);
  shape.color.setValue(nullptr);
  shape.texCoord.setValue(nullptr);
  shape.normalIndex.setNum(0);
  shape.colorIndex.setNum(0);
  shape.texCoordIndex.setNum(0);
  SoNode* const node = shape.coord.getValue();
  if (!node || !node->isOfType(SoVRMLCoordinate::getClassTypeId())) return "has no points";
  const auto& points = static_cast<const SoVRMLCoordinate*>(node)->point;
  return wrong_with_indices(shape.coordIndex, points.getNum());
}

std::string wrong_with_grid(SoVRMLElevationGrid& shape) {
  shape.normal.setValue(nullptr);
  shape.color.setValue(nullptr);
  shape.texCoord.setValue(nullptr);
  const std::int64_t rows = shape.zDimension.getValue(), columns = shape.xDimension.getValue();
  const bool is_sound =
      rows >= 2 && columns >= 2 && rows < (1 << 30) && rows * columns <= shape.height.getNum();
  return is_sound ? "" : "has more rows and columns than heights";
}

}  // namespace

bool is_no_surface(const SoNode& node) {
  static const std::set<std::string> kNone{"Normal",
                                           "NormalBinding",
                                           "PackedColor",
                                           "Material",
                                           "MaterialBinding",
                                           "BaseColor",
                                           "Texture2",
                                           "Texture2Transform",
                                           "TextureCoordinate2",
                                           "TextureCoordinate3",
                                           "TextureCoordinateBinding",
                                           "VRMLAppearance",
                                           "LineSet",
                                           "IndexedLineSet",
                                           "PointSet",
                                           "IndexedPointSet",
                                           "IndexedMarkerSet",
                                           "MarkerSet",
                                           "VRMLIndexedLineSet",
                                           "VRMLPointSet"};
  return kNone.count(node.getTypeId().getName().getString()) != 0;
}

std::string wrong_with_shape(SoCallbackAction& action, SoNode& shape) {
  const std::string kind = shape.getTypeId().getName().getString();
  if (kind == "IndexedFaceSet" || kind == "IndexedTriangleStripSet") {
    return wrong_with_indexed(static_cast<SoIndexedShape&>(shape), action);
  }
  if (kind == "FaceSet") {
    auto& faces = static_cast<SoFaceSet&>(shape);
    return wrong_with_counts(faces.numVertices, faces.startIndex.getValue(),
                             points_of(faces, action));
  }
  if (kind == "TriangleStripSet") {
    auto& strips = static_cast<SoTriangleStripSet&>(shape);
    return wrong_with_counts(strips.numVertices, strips.startIndex.getValue(),
                             points_of(strips, action));
  }
  if (kind == "QuadMesh") return wrong_with_quads(static_cast<SoQuadMesh&>(shape), action);
  if (kind == "VRMLIndexedFaceSet") {
    return wrong_with_vrml_faces(static_cast<SoVRMLIndexedFaceSet&>(shape));
  }
  if (kind == "VRMLElevationGrid") return wrong_with_grid(static_cast<SoVRMLElevationGrid&>(shape));
  static const std::set<std::string> kByItself{"Cube",     "Sphere",       "Cone",
                                               "Cylinder", "VRMLBox",      "VRMLSphere",
                                               "VRMLCone", "VRMLCylinder", "VRMLExtrusion"};
  return kByItself.count(kind) != 0 ? "" : "is of a kind of which no triangles are made";
}

}  // namespace prehend::robot::formats
