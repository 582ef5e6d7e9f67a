#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace prehend::text {

/// What a database of ours is, so that no other program's file is taken for it.
struct DatabaseKind {
  std::string holds;             ///< for messages, "grasps": "Name a file of grasps"
  std::int32_t application = 0;  ///< SQLite's application_id
  int version = 1;               ///< of the schema; newer ones are refused
  const char* schema = "";       ///< makes the tables of a new file
  const char* settings = "";     ///< PRAGMAs for each opening; may be empty
};

enum class DatabaseUse {
  kChange,  ///< made where it is not there
  kRead,    ///< must be there; nothing that is in it is changed
};

/// One SQLite file of a kind. All of its errors are InputError and name the file. For one thread at
/// a time; several processes may have it open, who waits longer than 5 s for another gives up.
class Database {
 public:
  /// @throws InputError when it cannot be opened, is of another kind or of a newer version.
  Database(const std::filesystem::path& file, const DatabaseKind& kind,
           DatabaseUse use = DatabaseUse::kChange);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  const std::string& file() const { return file_; }

  /// `doing` says in errors what failed: "cannot be changed".
  void execute(const char* text, const char* doing) const;

  /// All of `change` or nothing. @throws what `change` throws.
  void transaction(const std::function<void()>& change) const;

  /// Rows that the last statement changed.
  int changes() const;

  /// A statement with its values bound, in their order: text, numbers, bytes.
  class Statement {
   public:
    /// `owner` must outlive it.
    Statement(const Database& owner, const std::string& text);
    Statement& bind(const std::string& text);
    Statement& bind_bytes(const std::string& bytes);
    Statement& bind(double value);
    Statement& bind(std::int64_t value);
    /// True while there are rows.
    bool step();
    /// For new values; without preparing it once more.
    Statement& reset();
    double number(int column) const;
    std::int64_t integer(int column) const;
    std::string text(int column) const;

   private:
    struct Deleter {
      void operator()(sqlite3_stmt* statement) const;
    };
    Statement& checked(int code);
    const Database& owner_;
    std::unique_ptr<sqlite3_stmt, Deleter> statement_;
    int bound_ = 0;
  };

 private:
  [[noreturn]] void fail(const std::string& doing) const;
  std::int64_t pragma(const char* text) const;
  bool is_empty() const;
  void make_schema() const;
  void check_kind() const;

  std::string file_;
  DatabaseKind kind_;
  struct Closer {
    void operator()(sqlite3* connection) const;
  };
  std::unique_ptr<sqlite3, Closer> connection_;
};

}  // namespace prehend::text
