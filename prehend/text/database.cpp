#include "prehend/text/database.h"

#include <sqlite3.h>

#include <fmt/format.h>

#include "prehend/text/input_error.h"

namespace prehend::text {
namespace {

constexpr int kPatience = 5000;  // ms, for another writer

}  // namespace

void Database::Closer::operator()(sqlite3* connection) const { sqlite3_close(connection); }
void Database::Statement::Deleter::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Database::Database(const std::filesystem::path& file, const DatabaseKind& kind, DatabaseUse use)
    : file_(file.string()), kind_(kind) {
  // Who only reads must be able to roll back what a killed writer left half done.
  const int flags = SQLITE_OPEN_READWRITE | (use == DatabaseUse::kChange ? SQLITE_OPEN_CREATE : 0);
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(file_.c_str(), &opened, flags, nullptr);
  connection_.reset(opened);
  if (code != SQLITE_OK) fail("cannot be opened");
  sqlite3_busy_timeout(opened, kPatience);
  const std::string other = "is no database of " + kind_.holds;
  if (use == DatabaseUse::kChange) execute(kind_.settings, other.c_str());
  execute("SELECT count(*) FROM sqlite_master", other.c_str());
  if (is_empty()) {
    transaction([this] { make_schema(); });
  } else {
    check_kind();
  }
  if (use == DatabaseUse::kRead) execute("PRAGMA query_only=ON", other.c_str());
}

Database::~Database() = default;

void Database::fail(const std::string& doing) const {
  const int code = sqlite3_errcode(connection_.get());
  const std::string mend = code == SQLITE_BUSY ? "Another program holds it: try again"
                           : code == SQLITE_NOTADB || code == SQLITE_CORRUPT
                               ? "Name a file of " + kind_.holds + ", or a new one"
                               : "Check that the file and its folder can be read and written";
  throw InputError("'" + file_ + "': " + doing + ": " + sqlite3_errmsg(connection_.get()), mend);
}

void Database::execute(const char* text, const char* doing) const {
  if (sqlite3_exec(connection_.get(), text, nullptr, nullptr, nullptr) != SQLITE_OK) fail(doing);
}

void Database::transaction(const std::function<void()>& change) const {
  execute("BEGIN IMMEDIATE", "cannot be changed");
  try {
    change();
    execute("COMMIT", "cannot be changed");
  } catch (...) {
    // What was caught goes on to the caller. A rollback that fails is made up for by SQLite when
    // the file is closed or opened again, and would hide the first error.
    sqlite3_exec(connection_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

int Database::changes() const { return sqlite3_changes(connection_.get()); }

std::int64_t Database::pragma(const char* text) const {
  Statement statement(*this, text);
  return statement.step() ? statement.integer(0) : 0;
}

bool Database::is_empty() const {
  return pragma("PRAGMA application_id") == 0 && pragma("PRAGMA user_version") == 0 &&
         pragma("SELECT count(*) FROM sqlite_master") == 0;
}

void Database::make_schema() const {
  if (!is_empty()) return check_kind();  // another process was first
  execute(kind_.schema, "cannot be made");
  execute(fmt::format("PRAGMA application_id={}; PRAGMA user_version={}", kind_.application,
                      kind_.version)
              .c_str(),
          "cannot be made");
}

void Database::check_kind() const {
  if (pragma("PRAGMA application_id") != kind_.application) {
    throw InputError("'" + file_ + "' is another program's database",
                     "Name a file of " + kind_.holds + ", or a new one");
  }
  const std::int64_t version = pragma("PRAGMA user_version");
  if (version > kind_.version) {
    throw InputError(fmt::format("'{}' has version {}, newer than this program's {}", file_,
                                 version, kind_.version),
                     "Use a newer prehend");
  }
}

Database::Statement::Statement(const Database& owner, const std::string& text) : owner_(owner) {
  sqlite3_stmt* made = nullptr;
  if (sqlite3_prepare_v2(owner.connection_.get(), text.c_str(), -1, &made, nullptr) != SQLITE_OK) {
    owner.fail("cannot be asked");
  }
  statement_.reset(made);
}

Database::Statement& Database::Statement::bind(const std::string& text) {
  return checked(sqlite3_bind_text(statement_.get(), ++bound_, text.data(),
                                   static_cast<int>(text.size()), SQLITE_TRANSIENT));
}

Database::Statement& Database::Statement::bind_bytes(const std::string& bytes) {
  return checked(sqlite3_bind_blob(statement_.get(), ++bound_, bytes.data(),
                                   static_cast<int>(bytes.size()), SQLITE_TRANSIENT));
}

Database::Statement& Database::Statement::bind(double value) {
  return checked(sqlite3_bind_double(statement_.get(), ++bound_, value));
}

Database::Statement& Database::Statement::bind(std::int64_t value) {
  return checked(sqlite3_bind_int64(statement_.get(), ++bound_, value));
}

bool Database::Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) owner_.fail("cannot be read or written");
  return false;
}

Database::Statement& Database::Statement::reset() {
  // What it returns is the last step's error, which step() threw.
  sqlite3_reset(statement_.get());
  bound_ = 0;
  return *this;
}

double Database::Statement::number(int column) const {
  return sqlite3_column_double(statement_.get(), column);
}

std::int64_t Database::Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string Database::Statement::text(int column) const {
  const void* data = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return data ? std::string(static_cast<const char*>(data), static_cast<std::size_t>(size)) : "";
}

Database::Statement& Database::Statement::checked(int code) {
  if (code != SQLITE_OK) owner_.fail("cannot be asked");
  return *this;
}

}  // namespace prehend::text
