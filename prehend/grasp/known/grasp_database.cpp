#include "prehend/grasp/known/grasp_database.h"

#include <openssl/evp.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace prehend::grasp {
namespace {

using geometry::InputError;

constexpr int kVersion = 1;
constexpr int kApplication = 0x50524847;  // "PRHG"
constexpr int kPatience = 5000;           // ms, for another writer
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

struct StatementDeleter {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

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
  std::string file;
  sqlite3* connection = nullptr;

  ~Implementation() { sqlite3_close(connection); }

  [[noreturn]] void fail(const std::string& doing) const {
    const int code = sqlite3_errcode(connection);
    const char* mend = code == SQLITE_BUSY ? "Another program holds it: try again"
                       : code == SQLITE_NOTADB || code == SQLITE_CORRUPT
                           ? "Name a file of grasps, or a new one"
                           : "Check that the file and its folder can be read and written";
    throw InputError("'" + file + "': " + doing + ": " + sqlite3_errmsg(connection), mend);
  }

  void execute(const char* text, const char* doing) const {
    if (sqlite3_exec(connection, text, nullptr, nullptr, nullptr) != SQLITE_OK) fail(doing);
  }

  /// A statement with its values bound: text, numbers, bytes.
  class Statement {
   public:
    Statement(const Implementation& owner, const char* text) : owner_(owner) {
      sqlite3_stmt* made = nullptr;
      if (sqlite3_prepare_v2(owner.connection, text, -1, &made, nullptr) != SQLITE_OK) {
        owner.fail("cannot be asked");
      }
      statement_.reset(made);
    }
    Statement& bind(const std::string& text) {
      return checked(sqlite3_bind_text(statement_.get(), ++bound_, text.data(),
                                       static_cast<int>(text.size()), SQLITE_TRANSIENT));
    }
    Statement& bind_bytes(const std::string& bytes) {
      return checked(sqlite3_bind_blob(statement_.get(), ++bound_, bytes.data(),
                                       static_cast<int>(bytes.size()), SQLITE_TRANSIENT));
    }
    Statement& bind(double value) {
      return checked(sqlite3_bind_double(statement_.get(), ++bound_, value));
    }
    Statement& bind(std::int64_t value) {
      return checked(sqlite3_bind_int64(statement_.get(), ++bound_, value));
    }
    /// True while there are rows.
    bool step() {
      const int code = sqlite3_step(statement_.get());
      if (code == SQLITE_ROW) return true;
      if (code != SQLITE_DONE) owner_.fail("cannot be read or written");
      return false;
    }
    double number(int column) const { return sqlite3_column_double(statement_.get(), column); }
    std::int64_t integer(int column) const {
      return sqlite3_column_int64(statement_.get(), column);
    }
    std::string text(int column) const {
      const void* data = sqlite3_column_blob(statement_.get(), column);
      const int size = sqlite3_column_bytes(statement_.get(), column);
      return data ? std::string(static_cast<const char*>(data), static_cast<std::size_t>(size))
                  : "";
    }

   private:
    Statement& checked(int code) {
      if (code != SQLITE_OK) owner_.fail("cannot be asked");
      return *this;
    }
    const Implementation& owner_;
    std::unique_ptr<sqlite3_stmt, StatementDeleter> statement_;
    int bound_ = 0;
  };

  /// All of `change` or nothing.
  void transaction(const std::function<void()>& change) const {
    execute("BEGIN IMMEDIATE", "cannot be changed");
    try {
      change();
      execute("COMMIT", "cannot be changed");
    } catch (...) {
      // What was caught goes on to the caller. A rollback that fails is made up for by SQLite when
      // the file is closed or opened again, and would hide the first error.
      sqlite3_exec(connection, "ROLLBACK", nullptr, nullptr, nullptr);
      throw;
    }
  }

  std::int64_t pragma(const char* text) const {
    Statement statement(*this, text);
    return statement.step() ? statement.integer(0) : 0;
  }

  void open() {
    if (sqlite3_open_v2(file.c_str(), &connection, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE,
                        nullptr) != SQLITE_OK) {
      fail("cannot be opened");
    }
    sqlite3_busy_timeout(connection, kPatience);
    execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON",
            "is no database of grasps");
    transaction([this] { make_schema(); });
  }

  void make_schema() const {
    const std::int64_t application = pragma("PRAGMA application_id");
    const std::int64_t version = pragma("PRAGMA user_version");
    if (application == 0 && version == 0 && pragma("SELECT count(*) FROM sqlite_master") == 0) {
      execute(kSchema, "cannot be made");
      execute(
          fmt::format("PRAGMA application_id={}; PRAGMA user_version={}", kApplication, kVersion)
              .c_str(),
          "cannot be made");
      return;
    }
    if (application != kApplication) {
      throw InputError("'" + file + "' is another program's database",
                       "Name a file of grasps, or a new one");
    }
    if (version > kVersion) {
      throw InputError(
          fmt::format("'{}' has version {}, newer than this program's {}", file, version, kVersion),
          "Use a newer prehend");
    }
  }

  std::int64_t object(const std::string& hand, const std::string& hash) const {
    Statement find(*this, "SELECT id FROM object WHERE hand=? AND hash=?");
    find.bind(hand).bind(hash);
    return find.step() ? find.integer(0) : -1;
  }

  void insert(const std::string& hand, const std::string& hash, const std::string& name,
              const std::vector<StoredGrasp>& grasps) const {
    Statement known(*this,
                    "INSERT INTO object(hand, hash, name) VALUES(?, ?, ?) "
                    "ON CONFLICT(hand, hash) DO UPDATE SET name=excluded.name");
    known.bind(hand).bind(hash).bind(name).step();
    const std::int64_t id = object(hand, hash);
    for (const StoredGrasp& grasp : grasps) {
      const Eigen::Vector3d p = grasp.X_OG.translation();
      const Eigen::Quaterniond q(grasp.X_OG.linear());
      Statement add(*this,
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
    Statement statement(*this, "DELETE FROM object WHERE hand=? AND hash=?");
    statement.bind(hand).bind(hash).step();
    return sqlite3_changes(connection) > 0;
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
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->file = file.string();
  implementation_->open();
}
GraspDatabase::~GraspDatabase() = default;
GraspDatabase::GraspDatabase(GraspDatabase&&) noexcept = default;
GraspDatabase& GraspDatabase::operator=(GraspDatabase&&) noexcept = default;

void GraspDatabase::replace(const std::string& hand, const std::string& hash,
                            const std::string& name, const std::vector<StoredGrasp>& grasps) {
  check(hand, hash, grasps);
  implementation_->transaction([&] {
    implementation_->erase(hand, hash);
    implementation_->insert(hand, hash, name, grasps);
  });
}

void GraspDatabase::add(const std::string& hand, const std::string& hash, const std::string& name,
                        const std::vector<StoredGrasp>& grasps) {
  check(hand, hash, grasps);
  implementation_->transaction([&] { implementation_->insert(hand, hash, name, grasps); });
}

namespace {

/// From eleven columns beginning at `first`: x y z qw qx qy qz joints force quality score, then
/// attempts and successes.
template <class Statement>
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
  Implementation::Statement rows(*implementation_, text.c_str());
  rows.bind(hand).bind(hash);
  std::vector<StoredGrasp> result;
  while (rows.step()) result.push_back(read_grasp(rows, 0));
  return result;
}

bool GraspDatabase::record_execution(const std::string& hand, const std::string& hash,
                                     const geometry::RigidTransform& X_OG, bool held) {
  bool found = false;
  implementation_->transaction([&] {
    const std::string text = fmt::format(
        "SELECT {}, grasp.id FROM grasp JOIN object ON grasp.object=object.id "
        "WHERE hand=? AND hash=? ORDER BY grasp.id",
        kGraspColumns);
    Implementation::Statement rows(*implementation_, text.c_str());
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
    Implementation::Statement count(
        *implementation_, "UPDATE grasp SET attempts=attempts+1, successes=successes+? WHERE id=?");
    count.bind(std::int64_t{held ? 1 : 0}).bind(id).step();
  });
  return found;
}

std::vector<StoredObject> GraspDatabase::objects() const {
  Implementation::Statement rows(
      *implementation_,
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
  implementation_->transaction([&] { removed = implementation_->erase(hand, hash); });
  return removed;
}

void GraspDatabase::write_csv(std::ostream& out) const {
  out << "hand,hash,name,x_m,y_m,z_m,qw,qx,qy,qz,joints,force_n,quality,score,attempts,"
         "successes\r\n";
  const std::string text = fmt::format(
      "SELECT hand, hash, name, {} FROM grasp JOIN object ON grasp.object=object.id "
      "ORDER BY name, hash, hand, score DESC, grasp.id",
      kGraspColumns);
  Implementation::Statement rows(*implementation_, text.c_str());
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
    throw InputError("The grasps of '" + implementation_->file + "' cannot be written out",
                     "Check the space where they go");
  }
}

}  // namespace prehend::grasp
