// What programs of others make of the same files: MuJoCo's compiler, libsdformat's converter,
// Assimp.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#ifdef PREHEND_TEST_MUJOCO
#include <mujoco/mujoco.h>
#endif
#ifdef PREHEND_TEST_SDFORMAT
#include <sdf/sdf.hh>
#endif

#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "tests/robot/formats/mass_matrix.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::TriangleMesh;

class OracleOf : public RobotFiles {
 protected:
  /// The robot's shapes only cost time here.
  static RobotDescription own_robot(const fs::path& path) {
    LossReport loss;
    RobotDescription robot = read_robot(path, loss);
    for (LinkDescription& link : robot.links) {
      link.visuals.clear();
      link.collisions.clear();
    }
    return robot;
  }
  static std::vector<fs::path> own_files() {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator("config/robots")) {
      if (entry.path().extension() == ".urdf") files.push_back(entry.path());
    }
    return files;
  }
};

#ifdef PREHEND_TEST_MUJOCO
// Joints that follow are free to MuJoCo, whose couplings are constraints: they are here, too.
TEST_F(OracleOf, MassesAndMotionsIsMuJoCosCompiler) {
  for (const fs::path& path : own_files()) {
    SCOPED_TRACE(path.filename().string());
    RobotDescription robot = own_robot(path);
    for (JointDescription& joint : robot.joints) joint.follows.reset();
    LossReport loss;
    const fs::path written = file("x.xml", format_named("mjcf").write(robot, loss));
    std::array<char, 1000> error{};
    const std::unique_ptr<mjModel, void (*)(mjModel*)> model(
        mj_loadXML(written.c_str(), nullptr, error.data(), error.size()), mj_deleteModel);
    ASSERT_TRUE(model) << error.data();
    const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(model.get()), mj_deleteData);
    std::vector<std::string> joints;
    for (int i = 0; i < model->njnt; ++i) {
      joints.emplace_back(mj_id2name(model.get(), mjOBJ_JOINT, i));
    }
    ASSERT_EQ(model->nv, model->njnt);
    std::mt19937 random(5);
    for (int sample = 0; sample < 100; ++sample) {
      const auto q = random_positions(robot, random);
      for (int i = 0; i < model->njnt; ++i) {
        data->qpos[model->jnt_qposadr[i]] = q.at(joints[static_cast<std::size_t>(i)]);
      }
      mj_forward(model.get(), data.get());
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> full(model->nv,
                                                                                  model->nv);
      mj_fullM(model.get(), full.data(), data->qM);
      // Links without a mass have 1e-9 kg there.
      const Eigen::MatrixXd M = mass_matrix(robot, joints, q);
      const double least = 1e-8 * model->nbody;
      ASSERT_LE((M - full).norm(), 1e-9 * M.norm() + least) << "sample " << sample;
      const auto poses = link_poses(robot, q);
      const int root = mj_name2id(model.get(), mjOBJ_BODY, robot.links.front().name.c_str());
      for (const auto& [name, X] : poses) {
        const int body = mj_name2id(model.get(), mjOBJ_BODY, name.c_str());
        if (body < 0 || root < 0) continue;
        const Eigen::Map<const Eigen::Vector3d> p(data->xpos + 3 * body);
        const Eigen::Map<const Eigen::Vector3d> origin(data->xpos + 3 * root);
        ASSERT_LT((X.translation() - (p - origin)).norm(), 1e-9) << name;
      }
    }
  }
}
#endif

#ifdef PREHEND_TEST_SDFORMAT
sdf::Errors errors_of(const fs::path& path, sdf::Root& root) { return root.Load(path.string()); }

std::string words_of(const sdf::Errors& errors) {
  std::string all;
  for (const auto& error : errors) all += error.Message() + "\n";
  return all;
}

// libsdformat makes an SDF of a URDF, which is read here: links that fixed joints hold are parts of
// those above there, and all others stand where they stood.
TEST_F(OracleOf, UrdfIsLibsdformatsConverter) {
  int compared = 0;
  for (const fs::path& path : own_files()) {
    SCOPED_TRACE(path.filename().string());
    RobotDescription robot = own_robot(path);
    for (LinkDescription& link : robot.links) {  // it leaves out those without a mass
      if (link.inertial && link.inertial->mass > 0) continue;
      link.inertial.emplace();
      link.inertial->mass = 0.1;
      link.inertial->inertia = 1e-4 * Eigen::Matrix3d::Identity();
    }
    LossReport loss;
    const fs::path urdf = file("x.urdf", format_named("urdf").write(robot, loss));
    sdf::Root root;
    const auto errors = errors_of(urdf, root);
    ASSERT_TRUE(root.Model() && root.Model()->LinkCount() > 0) << words_of(errors);
    const RobotDescription again = read("x.sdf", root.Element()->ToString(""));
    EXPECT_GE(again.links.size(), 1U);
    // Only links that are there in both, and hang on joints that are, can be compared.
    const std::string first = again.links.front().name;
    std::mt19937 random(3);
    for (int sample = 0; sample < 20; ++sample) {
      auto q = random_positions(robot, random);
      for (auto& [name, value] : q) {
        if (!again.joint(name)) value = 0;
      }
      std::map<std::string, double> all;
      const LinkPoses tree(robot);
      for (std::size_t i = 0; i < robot.joints.size(); ++i) {
        const auto& leader = tree.leaders()[i];
        const std::string& name = robot.joints[static_cast<std::size_t>(leader.joint)].name;
        const auto found = q.find(name);
        const double at = found == q.end() ? 0 : found->second;
        all[robot.joints[i].name] = leader.by.multiplier() * at + leader.by.offset();
      }
      RobotDescription uncoupled = again;
      for (JointDescription& joint : uncoupled.joints) joint.follows.reset();
      const auto mine = link_poses(robot, q), its = link_poses(uncoupled, all);
      if (mine.count(first) == 0) break;
      for (const auto& [name, X] : its) {
        const auto found = mine.find(name);
        if (found == mine.end()) continue;
        const auto X_first = mine.at(first).inverse() * found->second;
        const auto X_its = its.at(first).inverse() * X;
        ASSERT_LT((X_first.translation() - X_its.translation()).norm(), 1e-9) << name;
        ++compared;
      }
    }
    // What fixed joints hold has its mass in the link above.
    double mass = 0, sum = 0;
    for (const LinkDescription& link : robot.links) mass += link.inertial ? link.inertial->mass : 0;
    for (const LinkDescription& link : again.links) sum += link.inertial ? link.inertial->mass : 0;
    EXPECT_NEAR(sum, mass, 1e-5 * mass);
  }
  EXPECT_GT(compared, 1000);
}

TEST_F(OracleOf, SdfIsReadByLibsdformat) {
  for (const fs::path& path : own_files()) {
    SCOPED_TRACE(path.filename().string());
    LossReport loss;
    const RobotDescription robot = own_robot(path);
    const fs::path written = file("x.sdf", format_named("sdf").write(robot, loss));
    sdf::Root root;
    const auto errors = errors_of(written, root);
    EXPECT_TRUE(errors.empty()) << words_of(errors);
    ASSERT_NE(root.Model(), nullptr);
    const auto poses = [&] {
      RobotDescription at_zero = robot;
      for (JointDescription& joint : at_zero.joints) joint.follows.reset();
      return link_poses(at_zero, {});
    }();
    for (const LinkDescription& link : robot.links) {
      if (link.name == "world") continue;
      const sdf::Link* its = root.Model()->LinkByName(link.name);
      ASSERT_NE(its, nullptr) << link.name;
      if (link.inertial) {
        EXPECT_EQ(its->Inertial().MassMatrix().Mass(), link.inertial->mass);
      }
      ignition::math::Pose3d X;
      ASSERT_TRUE(its->SemanticPose().Resolve(X, "__model__").empty());
      const Eigen::Vector3d p(X.Pos().X(), X.Pos().Y(), X.Pos().Z());
      EXPECT_LT((p - poses.at(link.name).translation()).norm(), 1e-9) << link.name;
    }
    for (const JointDescription& joint : robot.joints) {
      const sdf::Joint* its = root.Model()->JointByName(joint.name);
      ASSERT_NE(its, nullptr) << joint.name;
      if (!joint.lower || !joint.upper || !its->Axis()) continue;
      EXPECT_EQ(its->Axis()->Lower(), *joint.lower) << joint.name;
      EXPECT_EQ(its->Axis()->Upper(), *joint.upper) << joint.name;
    }
  }
}
#endif

/// The corners of a file's triangles, by Assimp alone: COLLADA's unit is applied, its up axis not.
std::vector<Eigen::Vector3d> corners_by_assimp(const fs::path& path) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene =
      importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices);
  std::vector<Eigen::Vector3d> corners;
  for (unsigned m = 0; scene && m < scene->mNumMeshes; ++m) {
    for (unsigned f = 0; f < scene->mMeshes[m]->mNumFaces; ++f) {
      const aiFace& face = scene->mMeshes[m]->mFaces[f];
      if (face.mNumIndices != 3) continue;
      for (unsigned k = 0; k < 3; ++k) {
        const aiVector3D& p = scene->mMeshes[m]->mVertices[face.mIndices[k]];
        corners.emplace_back(p.x, p.y, p.z);
      }
    }
  }
  return corners;
}

/// Extent, area-weighted centre and area: alike of surfaces that are alike, however they are cut.
void expect_same_surface(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& corners) {
  ASSERT_FALSE(corners.empty());
  Eigen::AlignedBox3d box;
  double area = 0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), its = middle;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    const Eigen::Vector3d &a = corners[i], &b = corners[i + 1], &c = corners[i + 2];
    const double one = 0.5 * (b - a).cross(c - a).norm();
    area += one;
    middle += one * (a + b + c) / 3;
    for (const auto* p : {&a, &b, &c}) box.extend(*p);
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices[static_cast<std::size_t>(t[0])],
                          &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                          &c = mesh.vertices[static_cast<std::size_t>(t[2])];
    its += 0.5 * (b - a).cross(c - a).norm() * (a + b + c) / 3;
  }
  const double extent = box.sizes().maxCoeff();
  EXPECT_LT((geometry::bounds(mesh).min() - box.min()).norm(), 1e-5 * extent);
  EXPECT_LT((geometry::bounds(mesh).max() - box.max()).norm(), 1e-5 * extent);
  EXPECT_NEAR(geometry::surface_area(mesh), area, 1e-4 * area);
  EXPECT_LT((its - middle).norm(), 1e-4 * area * extent);
}

TEST_F(OracleOf, MeshesIsAssimp) {
  // Every vertex, of a file that is written here.
  const TriangleMesh ball = geometry::make_sphere(0.07, 24);
  for (const char* name : {"ball.stl", "ball.obj", "ball.ply"}) {
    SCOPED_TRACE(name);
    geometry::write_mesh_file(folder_ / name, ball);
    ShapeMeshes meshes(folder_);
    const TriangleMesh& mesh = meshes.read(name);
    std::vector<Eigen::Vector3d> its = corners_by_assimp(folder_ / name), mine;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) mine.push_back(mesh.vertices[static_cast<std::size_t>(t[k])]);
    }
    ASSERT_EQ(mine.size(), its.size());
    for (std::size_t i = 0; i < mine.size(); ++i) {
      ASSERT_LT((mine[i] - its[i]).norm(), 1e-6) << i;
    }
    expect_same_surface(mesh, its);
  }
}

TEST_F(OracleOf, MeshesOfOthersIsAssimp) {
  if (shared_model("").empty()) GTEST_SKIP() << "no shared models";
  int compared = 0;
  for (const char* name :
       {"mjcf/shadow_hand/stls/hand/F1.stl", "mjcf/shadow_hand/stls/hand/lfmetacarpal.stl",
        "urdf/panda_ign/panda/meshes/visual/finger.dae",
        "urdf/panda_ign/panda/meshes/visual/hand.dae"}) {
    const fs::path path = shared_model(name);
    if (path.empty()) continue;
    SCOPED_TRACE(name);
    ShapeMeshes meshes(path.parent_path());
    expect_same_surface(meshes.read(path.filename().string()), corners_by_assimp(path));
    ++compared;
  }
  EXPECT_GE(compared, 2);
}

}  // namespace
}  // namespace prehend::robot::formats
