#include "prehend/grasp/known/grasp_database.h"

#include <openssl/evp.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "prehend/text/database.h"

namespace prehend::grasp {
namespace {

using geometry::InputError;
using Statement = text::Database::Statement;

constexpr double kMicrometre = 1e-6;
constexpr double kFarthest = 9e3;  // m

constexpr const char* kSchema = R"(
CREATE TABLE object(
  id INTEGER PRIMARY KEY, hand TEXT NOT NULL, hash TEXT NOT NULL, name TEXT NOT NULL,
  UNIQUE(hand, hash));
CREATE TABLE grasp(
  id INTEGER PRIMARY KEY,
  object INTEGER NOT NULL REFERENCES object(id) ON DELETE CASCADE,
  x REAL NOT NULL, y REAL NOT NULL, z REAL NOT NULL,
  qw REAL NOT NULL, qx REAL NOT NULL, qy REAL NOT NULL, qz REAL NOT NULL,
  joints BLOB NOT NULL, force REAL NOT NULL, quality REAL NOT NULL, score REAL NOT NULL,
  attempts INTEGER NOT NULL, successes INTEGER NOT NULL);
CREATE INDEX grasp_of_object ON grasp(object, score DESC);
)";

const text::DatabaseKind kKind{
    .holds = "grasps",
    .application = 0x50524847,  // "PRHG"
    .version = 1,
    .schema = kSchema,
    .settings = "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON"};

std::string to_bytes(const std::vector<double>& values) {
  std::string bytes(values.size() * sizeof(double), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

void check(const std::string& hand, const std::string& hash,
           const std::vector<StoredGrasp>& grasps) {
  if (hand.empty() || hash.empty()) {
    throw std::invalid_argument("GraspDatabase: hand and hash must not be empty");
  }
  for (const StoredGrasp& grasp : grasps) {
    const bool finite = grasp.X_OG.matrix().allFinite() && std::isfinite(grasp.force) &&
                        std::isfinite(grasp.quality) && std::isfinite(grasp.score) &&
                        std::all_of(grasp.joints.begin(), grasp.joints.end(),
                                    [](double value) { return std::isfinite(value); });
    if (!finite)
      throw std::invalid_argument("GraspDatabase: a grasp has a number that is not finite");
    if (grasp.attempts < 0 || grasp.successes < 0 || grasp.successes > grasp.attempts) {
      throw std::invalid_argument("GraspDatabase: successes must be between 0 and attempts");
    }
  }
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

}  // namespace

struct GraspDatabase::Implementation {
  text::Database database;

  explicit Implementation(const std::filesystem::path& file) : database(file, kKind) {}

  std::int64_t object(const std::string& hand, const std::string& hash) const {
    Statement find(database, "SELECT id FROM object WHERE hand=? AND hash=?");
    find.bind(hand).bind(hash);
    return find.step() ? find.integer(0) : -1;
  }

  void insert(const std::string& hand, const std::string& hash, const std::string& name,
              const std::vector<StoredGrasp>& grasps) const {
    Statement known(database,
                    "INSERT INTO object(hand, hash, name) VALUES(?, ?, ?) "
                    "ON CONFLICT(hand, hash) DO UPDATE SET name=excluded.name");
    known.bind(hand).bind(hash).bind(name).step();
    const std::int64_t id = object(hand, hash);
    for (const StoredGrasp& grasp : grasps) {
      const Eigen::Vector3d p = grasp.X_OG.translation();
      const Eigen::Quaterniond q(grasp.X_OG.linear());
      Statement add(database,
                    "INSERT INTO grasp(object, x, y, z, qw, qx, qy, qz, joints, force, quality, "
                    "score, attempts, successes) VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
      add.bind(id).bind(p.x()).bind(p.y()).bind(p.z());
      add.bind(q.w()).bind(q.x()).bind(q.y()).bind(q.z());
      add.bind_bytes(to_bytes(grasp.joints));
      add.bind(grasp.force).bind(grasp.quality).bind(grasp.score);
      add.bind(std::int64_t{grasp.attempts}).bind(std::int64_t{grasp.successes});
      add.step();
    }
  }

  bool erase(const std::string& hand, const std::string& hash) const {
    Statement statement(database, "DELETE FROM object WHERE hand=? AND hash=?");
    statement.bind(hand).bind(hash).step();
    return database.changes() > 0;
  }
};

std::string content_hash(const geometry::TriangleMesh& mesh) {
  std::string bytes;
  const auto append = [&bytes](std::int64_t value) {
    for (int shift = 0; shift < 64; shift += 8) {
      bytes.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> shift & 0xff));
    }
  };
  append(static_cast<std::int64_t>(mesh.vertices.size()));
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    for (const double value : vertex) {
      if (!(std::abs(value) < kFarthest)) {
        throw std::invalid_argument("content_hash: a vertex is not finite, or too far away");
      }
      append(std::llround(value / kMicrometre));
    }
  }
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (const int index : triangle) append(index);
  }
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("content_hash: OpenSSL has no SHA-256");
  }
  std::string text;
  for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

GraspDatabase::GraspDatabase(const std::filesystem::path& file)
    : implementation_(std::make_unique<Implementation>(file)) {}
GraspDatabase::~GraspDatabase() = default;
GraspDatabase::GraspDatabase(GraspDatabase&&) noexcept = default;
GraspDatabase& GraspDatabase::operator=(GraspDatabase&&) noexcept = default;

void GraspDatabase::replace(const std::string& hand, const std::string& hash,
                            const std::string& name, const std::vector<StoredGrasp>& grasps) {
  check(hand, hash, grasps);
  implementation_->database.transaction([&] {
    implementation_->erase(hand, hash);
    implementation_->insert(hand, hash, name, grasps);
  });
}

void GraspDatabase::add(const std::string& hand, const std::string& hash, const std::string& name,
                        const std::vector<StoredGrasp>& grasps) {
  check(hand, hash, grasps);
  implementation_->database.transaction([&] { implementation_->insert(hand, hash, name, grasps); });
}

namespace {

/// From eleven columns beginning at `first`: x y z qw qx qy qz joints force quality score, then
/// attempts and successes.
StoredGrasp read_grasp(const Statement& row, int first) {
  StoredGrasp grasp;
  const auto number = [&](int k) { return row.number(first + k); };
  grasp.X_OG =
      geometry::make_transform(Eigen::Quaterniond(number(3), number(4), number(5), number(6)),
                               {number(0), number(1), number(2)});
  const std::string bytes = row.text(first + 7);
  grasp.joints.resize(bytes.size() / sizeof(double));
  std::memcpy(grasp.joints.data(), bytes.data(), grasp.joints.size() * sizeof(double));
  grasp.force = number(8);
  grasp.quality = number(9);
  grasp.score = number(10);
  grasp.attempts = static_cast<int>(row.integer(first + 11));
  grasp.successes = static_cast<int>(row.integer(first + 12));
  return grasp;
}

constexpr const char* kGraspColumns =
    "x, y, z, qw, qx, qy, qz, joints, force, quality, score, attempts, successes";

}  // namespace

std::vector<StoredGrasp> GraspDatabase::grasps(const std::string& hand,
                                               const std::string& hash) const {
  const std::string text = fmt::format(
      "SELECT {} FROM grasp JOIN object ON grasp.object=object.id WHERE hand=? AND hash=? "
      "ORDER BY score DESC, grasp.id",
      kGraspColumns);
  Statement rows(implementation_->database, text);
  rows.bind(hand).bind(hash);
  std::vector<StoredGrasp> result;
  while (rows.step()) result.push_back(read_grasp(rows, 0));
  return result;
}

bool GraspDatabase::record_execution(const std::string& hand, const std::string& hash,
                                     const geometry::RigidTransform& X_OG, bool held) {
  bool found = false;
  implementation_->database.transaction([&] {
    const std::string text = fmt::format(
        "SELECT {}, grasp.id FROM grasp JOIN object ON grasp.object=object.id "
        "WHERE hand=? AND hash=? ORDER BY grasp.id",
        kGraspColumns);
    Statement rows(implementation_->database, text);
    rows.bind(hand).bind(hash);
    std::int64_t id = -1;
    std::pair<double, double> nearest;
    while (rows.step()) {
      const geometry::RigidTransform known = read_grasp(rows, 0).X_OG;
      const std::pair<double, double> far{
          (known.translation() - X_OG.translation()).norm(),
          Eigen::Quaterniond(known.linear()).angularDistance(Eigen::Quaterniond(X_OG.linear()))};
      if (id >= 0 && far >= nearest) continue;
      nearest = far;
      id = rows.integer(13);
    }
    found = id >= 0;
    if (!found) return;
    Statement count(implementation_->database,
                    "UPDATE grasp SET attempts=attempts+1, successes=successes+? WHERE id=?");
    count.bind(std::int64_t{held ? 1 : 0}).bind(id).step();
  });
  return found;
}

std::vector<StoredObject> GraspDatabase::objects() const {
  Statement rows(
      implementation_->database,
      "SELECT hash, name, hand, (SELECT count(*) FROM grasp WHERE grasp.object=object.id) "
      "FROM object ORDER BY name, hash, hand");
  std::vector<StoredObject> result;
  while (rows.step()) {
    result.push_back({rows.text(0), rows.text(1), rows.text(2), static_cast<int>(rows.integer(3))});
  }
  return result;
}

bool GraspDatabase::remove(const std::string& hand, const std::string& hash) {
  bool removed = false;
  implementation_->database.transaction([&] { removed = implementation_->erase(hand, hash); });
  return removed;
}

void GraspDatabase::write_csv(std::ostream& out) const {
  out << "hand,hash,name,x_m,y_m,z_m,qw,qx,qy,qz,joints,force_n,quality,score,attempts,"
         "successes\r\n";
  const std::string text = fmt::format(
      "SELECT hand, hash, name, {} FROM grasp JOIN object ON grasp.object=object.id "
      "ORDER BY name, hash, hand, score DESC, grasp.id",
      kGraspColumns);
  Statement rows(implementation_->database, text);
  while (rows.step()) {
    const StoredGrasp grasp = read_grasp(rows, 3);
    const Eigen::Vector3d p = grasp.X_OG.translation();
    const Eigen::Quaterniond q(grasp.X_OG.linear());
    out << fmt::format("{},{},{},{},{},{},{},{},{},{},\"{}\",{},{},{},{},{}\r\n",
                       quoted(rows.text(0)), quoted(rows.text(1)), quoted(rows.text(2)), p.x(),
                       p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), fmt::join(grasp.joints, " "),
                       grasp.force, grasp.quality, grasp.score, grasp.attempts, grasp.successes);
  }
  if (!out) {
    throw InputError(
        "The grasps of '" + implementation_->database.file() + "' cannot be written out",
        "Check the space where they go");
  }
}

}  // namespace prehend::grasp
