#pragma once

#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::grasp {

/// What identifies an object's shape: SHA-256 (FIPS 180-4), in hexadecimal, of the mesh's vertices,
/// rounded to a micrometre, and triangles, both in the order of the file. The same mesh read again
/// has the same hash; a mesh in another order or pose is another object.
/// @throws std::invalid_argument for a mesh with a vertex that is not finite, or over 9 km away.
std::string content_hash(const geometry::TriangleMesh& mesh);

/// A grasp of a known object.
struct StoredGrasp {
  geometry::RigidTransform X_OG = geometry::RigidTransform::Identity();  // hand in the object
  std::vector<double> joints;  // rad or m: the hand's positions before it closes
  double force = 0;            // N
  double quality = 0;          // epsilon, see wrench_hull.h
  double score = 0;            // 0 to 1
  int attempts = 0;            // how often it was executed
  int successes = 0;           // and held
};

struct StoredObject {
  std::string hash;  // content_hash()
  std::string name;  // for people
  std::string hand;
  int grasps = 0;
};

/// A file of grasps by hand and object (SQLite 3, write-ahead log). Several processes may have it
/// open: readers never wait, a writer waits up to five seconds for another one. A change is whole
/// or not there, whatever dies when. One object for one thread.
class GraspDatabase {
 public:
  /// Opens the file, or makes it. @throws geometry::InputError naming the file: not a database,
  /// another program's, of a newer version, or not writable.
  explicit GraspDatabase(const std::filesystem::path& file);
  ~GraspDatabase();
  GraspDatabase(GraspDatabase&&) noexcept;
  GraspDatabase& operator=(GraspDatabase&&) noexcept;

  /// Puts `grasps` in place of all that are known of the object with this hand.
  /// @throws std::invalid_argument for an empty hand or hash, or a number that is not finite;
  /// geometry::InputError when the file cannot be written or stays locked.
  void replace(const std::string& hand, const std::string& hash, const std::string& name,
               const std::vector<StoredGrasp>& grasps);
  /// Adds `grasps` to what is known.
  void add(const std::string& hand, const std::string& hash, const std::string& name,
           const std::vector<StoredGrasp>& grasps);

  /// The known grasps of the object with this hand, best score first; none is no error.
  std::vector<StoredGrasp> grasps(const std::string& hand, const std::string& hash) const;
  /// Counts an execution of the grasp that is nearest to X_OG (its origin, then its turn): false
  /// when there is none of this object and hand.
  bool record_execution(const std::string& hand, const std::string& hash,
                        const geometry::RigidTransform& X_OG, bool held);

  /// All objects by name, each with every hand that has grasps of it.
  std::vector<StoredObject> objects() const;
  /// False when there is nothing of it.
  bool remove(const std::string& hand, const std::string& hash);

  /// One line for each grasp, CSV (RFC 4180) with a header: hand, hash, name, position [m],
  /// quaternion (w first), joints, force, quality, score, attempts, successes.
  void write_csv(std::ostream& out) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::grasp
