// Files of Inventor and VRML of strangers who mean harm: with nearly each of these Coin ended the
// program. They are refused in words; their like that is sound is read.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/inventor_mesh.h"
#include "tests/robot/formats/hostile_files.h"

namespace prehend::robot::formats {
namespace {

using testing::HasSubstr;

class HostileInventor : public RobotFiles {
 protected:
  /// Empty: it was read.
  std::string error_of_mesh(const std::string& name, const std::string& text) {
    try {
      read_inventor_mesh(file(name, text));
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "";
  }
  std::string error_of_inventor(const std::string& shapes) {
    return error_of_mesh("a.iv", "#Inventor V2.1 ascii\nSeparator { " + shapes + " }\n");
  }
  std::string error_of_vrml(const std::string& geometry) {
    return error_of_mesh("a.wrl", "#VRML V2.0 utf8\nShape { geometry " + geometry + " }\n");
  }
};

const std::string kPoints = "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, 1 1 0 ] } ";

TEST_F(HostileInventor, IndicesAreOfPointsThatAreThere) {
  for (const std::string shape :
       {"IndexedFaceSet { coordIndex [ 0, 1, 3, 2, -1 ] }",
        "IndexedTriangleStripSet { coordIndex [ 0, 1, 2, 3, -1 ] }",
        "FaceSet { numVertices [ 4 ] }", "FaceSet { numVertices [ -1 ] }",
        "FaceSet { startIndex 1 numVertices [ 3 ] }", "TriangleStripSet { numVertices [ 4 ] }",
        "QuadMesh { verticesPerRow 2 verticesPerColumn 2 }"}) {
    EXPECT_EQ(error_of_inventor(kPoints + shape), "") << shape;
  }
  for (const std::string shape :
       {"IndexedFaceSet { coordIndex [ 0, 1000000, 2, -1 ] }",
        "IndexedFaceSet { coordIndex [ 0, -5, 2, -1 ] }",
        "IndexedTriangleStripSet { coordIndex [ 0, 5, 900000, 7, -1 ] }",
        "FaceSet { numVertices [ 1000000 ] }", "FaceSet { numVertices [ -7 ] }",
        "FaceSet { numVertices [ 3, 3 ] }", "FaceSet { startIndex 2147483647 }",
        "FaceSet { startIndex -1 numVertices [ 3 ] }",
        "TriangleStripSet { numVertices [ 1000000 ] }",
        "QuadMesh { verticesPerRow 100000 verticesPerColumn 100000 }",
        "QuadMesh { verticesPerRow -2 verticesPerColumn -2 }",
        "FaceSet { vertexProperty VertexProperty { vertex [ 0 0 0 ] } numVertices [ 3 ] }"}) {
    EXPECT_THAT(error_of_inventor(kPoints + shape), HasSubstr(shape.substr(0, shape.find(' '))))
        << shape;
  }
}

TEST_F(HostileInventor, ShapesOfVrmlAreLookedOverToo) {
  const std::string coord = "IndexedFaceSet { coord Coordinate { point [ 0 0 0 1 0 0 0 1 0 ] } ";
  EXPECT_EQ(error_of_vrml(coord + "coordIndex [ 0 1 2 -1 ] normalIndex [ 9 9 9 ] }"), "");
  EXPECT_EQ(error_of_vrml("ElevationGrid { xDimension 2 zDimension 2 height [ 0 1 2 3 ] }"), "");
  EXPECT_THAT(error_of_vrml(coord + "coordIndex [ 0 900000 2 -1 ] }"),
              HasSubstr("none of its points"));
  EXPECT_THAT(error_of_vrml("IndexedFaceSet { coordIndex [ 0 1 2 -1 ] }"), HasSubstr("no points"));
  EXPECT_THAT(
      error_of_vrml("ElevationGrid { xDimension 100000 zDimension 100000 height [ 0 1 2 ] }"),
      HasSubstr("than heights"));
}

// Without a display; and with one it is the display's business.
TEST_F(HostileInventor, WhatNeedsADisplayIsRefused) {
  EXPECT_THAT(
      error_of_inventor(kPoints + "NurbsSurface { numUControlPoints 2 numVControlPoints 2 "
                                  "uKnotVector [ 0, 0, 1, 1 ] vKnotVector [ 0, 0, 1, 1 ] }"),
      HasSubstr("NurbsSurface is of a kind"));
  EXPECT_THAT(error_of_inventor("Text3 { string [ \"a\" ] }"), HasSubstr("Text3 is of a kind"));
  EXPECT_EQ(error_of_inventor(kPoints + "PointSet { } LineSet { } Cube { }"), "");
}

TEST_F(HostileInventor, GraphsDoNotGrow) {
  std::string deep, doubling = "DEF n0 Separator { Cube { } } ";
  for (int i = 0; i < 200000; ++i) deep += "Separator { ";
  EXPECT_THAT(error_of_inventor(deep), HasSubstr("deeper than 200"));
  // Brackets in texts and comments are none.
  EXPECT_THAT(error_of_inventor("Info { string \"}}}}}\" } # }}}}\n" + deep),
              HasSubstr("deeper than 200"));
  EXPECT_EQ(error_of_inventor("Info { string \"{{{\\\"{{{\" } # {{{{\n Cube { }"), "");
  for (int i = 0; i < 40; ++i) {
    const std::string n = std::to_string(i), next = std::to_string(i + 1);
    doubling += "DEF n" + next + " Separator { USE n" + n + " USE n" + n + " } ";
  }
  EXPECT_THAT(error_of_inventor(doubling), HasSubstr("more than 100,000 nodes"));
  EXPECT_THAT(error_of_inventor("Array { numElements1 30000 numElements2 30000 Cube { } }"),
              HasSubstr("more than 100,000 nodes"));
  EXPECT_THAT(error_of_mesh("a.wrl", "#VRML V2.0 utf8\nPROTO P [ ] { Group { } }\nP { }\n"),
              HasSubstr("PROTO"));
}

TEST_F(HostileInventor, IncludesAreFoundHoweverTheyAreWritten) {
  for (const std::string include :
       {"File { name \"a.iv\" }", "File{name\"a.iv\"}", "File { # here\n name # there\n \"a.iv\" }",
        "File { fields [ SFString name ] name \"a.iv\" }"}) {
    EXPECT_THAT(error_of_inventor(include), HasSubstr("includes itself")) << include;
  }
  EXPECT_THAT(error_of_mesh("a.iv", "#Inventor V2.1 binary  \n\1\2\3"),
              HasSubstr("binary or packed"));
  EXPECT_THAT(error_of_mesh("a.iv", "\x1f\x8b\x08"), HasSubstr("binary or packed"));
  file("packed.iv", "\x1f\x8b\x08");
  EXPECT_THAT(error_of_inventor("File { name \"packed.iv\" }"), HasSubstr("binary or packed"));
}

}  // namespace
}  // namespace prehend::robot::formats
