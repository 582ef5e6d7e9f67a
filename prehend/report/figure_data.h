#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "prehend/geometry/image.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/text/json.h"

// What figures that web/src/report draws have in common.
namespace prehend::report {

/// "#rrggbb".
std::string color_text(const geometry::Rgb& color);

/// Their bytes as base64.
std::string packed(const std::vector<float>& numbers);
std::string packed(const std::vector<std::uint32_t>& numbers);

/// Sets "vertices" (float32) and "triangles" (uint32) of a figure's object, without vertices of no
/// triangle. @throws std::invalid_argument, beginning with `what`, for what is not finite and for a
/// triangle of corners that are not there.
void set_mesh(text::Json& object, const geometry::TriangleMesh& mesh, const std::string& what);

/// JSON as it may stand in a page's script: without any '<', which might end it. Only texts can
/// have one.
std::string for_script(const text::Json& json);

/// The program that draws figures in a page, web/dist/report.js of prehend's tree.
/// @throws geometry::InputError when it is not there.
std::string figure_program();

}  // namespace prehend::report
