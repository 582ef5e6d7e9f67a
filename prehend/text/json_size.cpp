#include "prehend/text/json_size.h"

#include <set>
#include <vector>

#include <nlohmann/json.hpp>

#include "prehend/text/input_error.h"

namespace prehend::text {
namespace {

/// (The library's own call-back for each value looks through all values before it.)
class JsonBounds : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit JsonBounds(const std::string& file) : file_(file) {}

  bool null() override { return count(); }
  bool boolean(bool) override { return count(); }
  bool number_integer(number_integer_t) override { return count(); }
  bool number_unsigned(number_unsigned_t) override { return count(); }
  bool number_float(number_float_t, const string_t&) override { return count(); }
  bool string(string_t&) override { return count(); }
  bool binary(binary_t&) override { return count(); }
  bool start_object(std::size_t) override {
    keys_.emplace_back();
    return start();
  }
  bool end_object() override {
    keys_.pop_back();
    return end();
  }
  bool start_array(std::size_t) override { return start(); }
  bool end_array() override { return end(); }
  bool key(string_t& name) override {
    if (!keys_.back().insert(name).second) {
      throw InputError(file_ + ": the key '" + name + "' is there twice in one object",
                       "Take one of them away");
    }
    constexpr std::size_t kMostKeys = 10000;  // each is looked for among those before it
    if (keys_.back().size() > kMostKeys) {
      throw InputError(file_ + " has an object of more than 10000 keys", "Mend the file");
    }
    return count();
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;  // whoever reads it says it
  }

 private:
  bool start() {
    constexpr int kDeepest = 32;
    if (++depth_ > kDeepest) throw InputError(file_ + " is nested deeper than 32", "Mend the file");
    return count();
  }
  bool end() {
    --depth_;
    return true;
  }
  bool count() {
    constexpr std::size_t kMostValues = 2000000;
    if (++values_ <= kMostValues) return true;
    throw InputError(file_ + " has more than two million values: no file of a robot",
                     "Check the path");
  }

  const std::string& file_;
  std::vector<std::set<std::string>> keys_;  // of the objects that are open
  int depth_ = 0;
  std::size_t values_ = 0;
};

}  // namespace

void refuse_json_bomb(const std::string& text, const std::string& file) {
  JsonBounds bounds(file);
  nlohmann::json::sax_parse(text, &bounds);
}

}  // namespace prehend::text
