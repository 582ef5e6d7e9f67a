#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/closing/widest_opening.h"
#include "prehend/perception/recorded_cloud.h"
#include "prehend/perception/segmentation.h"
#include "prehend/robot/hand_model.h"
#include "prehend/shape/body_evidence.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/surface/model.h"
#include "python/arrays.h"
#include "python/bound_types.h"

namespace prehend::python {
namespace {

using geometry::Plane;
using geometry::PointCloud;
using geometry::TriangleMesh;
using perception::ObjectHypothesis;
using perception::SegmentedScene;
using shape::CompletedShape;
using surface::ObjectModel;

/// A scene with what was assumed of the cloud.
struct Scene {
  SegmentedScene segmented;
  std::vector<std::string> notes;
  std::optional<Chain> chain;  // that it was seen by
};

fidelity::ShapeOptions shape_options(const std::optional<Chain>& chain) {
  if (!chain) return {};
  const fidelity::ChosenChain& chosen = chain->chosen;
  return fidelity::shape_options(
      fidelity::stage_setting(chosen.front, chosen.setting, fidelity::Stage::kShape));
}

Scene segment(const PointCloud& cloud, const std::optional<Eigen::Matrix4d>& viewpoint,
              const std::optional<Eigen::Vector3d>& up, const std::string& table, double scale,
              const std::string& split, const robot::HandModel* hand, double min_height,
              const std::optional<Chain>& chain) {
  perception::RecordedCloudOptions options =
      perception::read_recorded_cloud_options(scale, "", "", table);
  if (viewpoint) options.viewpoint = read_pose(*viewpoint, "viewpoint");
  options.up = up;
  fidelity::SeeingOptions seeing;
  perception::SegmentationOptions& segmentation = seeing.segmentation;
  std::optional<double> widest_opening;
  if (hand != nullptr) widest_opening = grasp::widest_opening(*hand);
  perception::choose_splitting(split, widest_opening, &segmentation);
  segmentation.min_height = min_height;
  segmentation.body_evidence = shape::log_odds_of_one_body;
  if (chain) {
    const fidelity::ChosenChain& chosen = chain->chosen;
    fidelity::apply_first_stage(chosen.front, chosen.setting, &seeing);
  }
  py::gil_scoped_release free;
  geometry::CloudFile file;
  file.cloud = cloud;
  const perception::RecordedCloud recorded = perception::interpret_recorded_cloud(file, options);
  return {perception::segment_recorded_cloud(thinned(recorded, seeing.points), segmentation,
                                             seeing.table),
          recorded.notes, chain};
}

std::vector<Completion> complete(const Scene& scene, int alternatives, bool other_methods) {
  shape::CompletionOptions options = shape_options(scene.chain).completion;
  if (scene.chain && alternatives > 0) {
    throw geometry::InputError("alternatives are chosen by the chain that the scene was seen by",
                               "Leave them away, or segment without chain=");
  }
  if (!scene.chain) options.alternatives = alternatives;
  options.other_methods = other_methods;
  std::vector<Completion> completions;
  std::vector<shape::SceneShape> shapes = shape::complete_scene(scene.segmented, options);
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    Completion& one = completions.emplace_back();
    one.chain = scene.chain;
    one.support_W = support_of(scene.segmented, scene.segmented.objects[k]);
    if (!shapes[k].error) {
      one.shape = std::move(shapes[k].shape);
      continue;
    }
    try {
      std::rethrow_exception(shapes[k].error);
    } catch (const geometry::InputError& error) {
      one.problem = error.problem();
    }
  }
  return completions;
}

std::pair<Eigen::Vector3d, double> pair_of(const Plane& plane) {
  return {plane.normal, plane.offset};
}

void bind_scenes(py::module_& m) {
  py::class_<ObjectHypothesis>(m, "SeenObject", "One object as it was seen.")
      .def_readonly("id", &ObjectHypothesis::id, "Its place in Scene.objects.")
      .def_readonly("cloud", &ObjectHypothesis::cloud_W, "Its points in the world frame.",
                    py::return_value_policy::reference_internal)
      .def_property_readonly(
          "mask",
          [](const py::object& self) {
            return image_of<std::uint8_t>(self.cast<const ObjectHypothesis&>().mask, self);
          },
          "height x width uint8, 255 where it is seen; a read-only view.")
      .def_readonly("touches_image_border", &ObjectHypothesis::touches_image_border,
                    "Whether the image or max_height cuts it.")
      .def_readonly("occluded_share", &ObjectHypothesis::occluded_share,
                    "0..1 of its outline, that another object hides.")
      .def_readonly("may_be_several", &ObjectHypothesis::may_be_several,
                    "Whether it has a step as two things of one colour have.");
  py::class_<Scene>(
      m, "Scene",
      "A table and the objects on it. The world is made from the table: z = 0 on it, up.")
      .def("__len__", [](const Scene& s) { return s.segmented.objects.size(); })
      .def_property_readonly(
          "objects",
          [](const py::object& self) {
            const auto& scene = self.cast<const Scene&>();
            py::list objects;
            for (const ObjectHypothesis& one : scene.segmented.objects) {
              objects.append(py::cast(one, py::return_value_policy::reference_internal, self));
            }
            return objects;
          },
          "The objects, largest first.")
      .def_property_readonly(
          "table", [](const Scene& s) { return pair_of(s.segmented.table_W); },
          "(normal, offset [m]) of the plane {p: normal . p = offset}.")
      .def_property_readonly(
          "camera_pose", [](const Scene& s) { return Eigen::Matrix4d(s.segmented.X_WC.matrix()); },
          "4 x 4: the camera's optical frame in the world.")
      .def_property_readonly(
          "depth",
          [](const py::object& self) {
            return image_of<float>(self.cast<const Scene&>().segmented.depth, self);
          },
          "height x width float32 [m] along the optical axis, NaN where unknown; a read-only view.")
      .def_property_readonly(
          "dropped", [](const Scene& s) { return s.segmented.dropped; },
          "What is over the table and no object, with the reason.")
      .def_readonly("notes", &Scene::notes, "What was assumed of the cloud, in words.")
      .def_readonly("chain", &Scene::chain, "The Chain that it was seen by; None: the defaults.")
      .def("complete", &complete, py::arg("alternatives") = 0, py::arg("other_methods") = false,
           py::call_guard<py::gil_scoped_release>(),
           "Predicts what was not seen of every object, by symmetry scored against visibility; a "
           "Completion each. alternatives: how many other mirrors are kept; other_methods: also a "
           "surface of revolution, an extrusion, the hull, for a Belief.");
  m.def(
      "segment", &segment, py::arg("cloud"), py::kw_only(), py::arg("viewpoint") = py::none(),
      py::arg("up") = py::none(), py::arg("table") = "auto", py::arg("scale") = 1.0,
      py::arg("split") = "tops", py::arg("hand") = py::none(), py::arg("min_height") = 0.0,
      py::arg("chain") = py::none(),
      "Finds table and objects of a recorded cloud. viewpoint: 4 x 4, the camera's optical frame "
      "in the cloud's; up: 3 numbers; table: auto, find, none or 'a b c d' [m]; scale: metres per "
      "unit; split: none, tops, touching, shapes, or wide: shapes, of what is wider than `hand` "
      "opens; min_height [m], 0: by the table's noise; chain: "
      "a Chain, which all that is made of the scene is made by. Raises InputError where there is "
      "no "
      "table.");
}

void bind_completions(py::module_& m) {
  py::class_<Completion>(m, "Completion", "An object's seen and predicted points.")
      .def_readonly("problem", &Completion::problem, "Why there is none; '' when there is one.")
      .def_property_readonly(
          "confidence", [](const Completion& c) { return c.get().confidence; },
          "0..1: probability that it is within 5 mm of the truth on average.")
      .def_property_readonly(
          "method", [](const Completion& c) { return shape::name(c.get().method); },
          "mirror, rotation, extrusion, convex_hull or refused_mirror.")
      .def_property_readonly(
          "cloud",
          [](const py::object& self) {
            return py::cast(self.cast<const Completion&>().get().cloud_W,
                            py::return_value_policy::reference_internal, self);
          },
          "Seen points, then predicted ones, in the world frame.")
      .def_property_readonly(
          "is_predicted",
          [](const Completion& c) {
            const auto& origin = c.get().origin;
            py::array_t<bool> predicted(static_cast<py::ssize_t>(origin.size()));
            bool* to = predicted.mutable_data();
            for (const shape::PointOrigin one : origin) *to++ = one != shape::PointOrigin::kSeen;
            return predicted;
          },
          "n bool: of each point of cloud, whether nobody saw it.")
      .def_property_readonly(
          "point_confidence",
          [](const Completion& c) { return numbers_of(c.get().point_confidence); },
          "n float32, 0..1: probability that the surface is there.")
      .def_property_readonly(
          "symmetry_plane",
          [](const Completion& c) {
            const auto& s = c.get().symmetry;
            return std::pair(s.normal_W, s.normal_W.dot(s.point_W));
          },
          "(normal, offset [m]) of the plane of symmetry; of other methods a nominal one.")
      .def(
          "model",
          [](const Completion& c) {
            return surface::make_object_model(c.get(), c.support_W, shape_options(c.chain).model);
          },
          py::call_guard<py::gil_scoped_release>(),
          "The watertight solid: Poisson surface, convex pieces, what each vertex rests on.");
  py::enum_<surface::SurfaceOrigin>(m, "SurfaceOrigin", "What a place of the surface rests on.")
      .value("SEEN", surface::SurfaceOrigin::kSeen)
      .value("PREDICTED", surface::SurfaceOrigin::kPredicted)
      .value("ASSUMED", surface::SurfaceOrigin::kAssumed)
      .value("TOUCHED", surface::SurfaceOrigin::kTouched);
  py::class_<ObjectModel>(m, "ObjectModel", "A solid that grasps are planned on.")
      .def_readonly("mesh", &ObjectModel::mesh_W, "Its surface in the world frame.")
      .def_readonly("convex_pieces", &ObjectModel::convex_pieces_W,
                    "Closed convex meshes that cover it.")
      .def_readonly("alternatives", &ObjectModel::alternatives_W, "Meshes that it may be as well.")
      .def_readonly("substitute", &ObjectModel::substitute,
                    "What stands in for the completed points, and why; '' when nothing does.")
      .def_readonly("guessed_area", &ObjectModel::guessed_area,
                    "0..1 of the area, that nobody saw.")
      .def_property_readonly(
          "vertex_origin",
          [](const ObjectModel& model) {
            py::array_t<std::uint8_t> origin(static_cast<py::ssize_t>(model.vertex_origin.size()));
            std::uint8_t* to = origin.mutable_data();
            for (const auto one : model.vertex_origin) *to++ = static_cast<std::uint8_t>(one);
            return origin;
          },
          "v uint8, values of SurfaceOrigin; empty of a mesh that is known.")
      .def_property_readonly(
          "vertex_confidence",
          [](const ObjectModel& model) { return numbers_of(model.vertex_confidence); },
          "v float32, 0..1; empty of a mesh that is known.");
  m.def(
      "model_of_mesh", [](const TriangleMesh& mesh) { return surface::model_of_mesh(mesh); },
      py::arg("mesh"), py::call_guard<py::gil_scoped_release>(),
      "The solid of a mesh [m] that is known, not predicted.");
}

}  // namespace

void bind_prediction(py::module_& module) {
  bind_scenes(module);
  bind_completions(module);
}

}  // namespace prehend::python
