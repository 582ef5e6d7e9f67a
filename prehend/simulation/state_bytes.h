#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"

/// Values as bytes and back, exactly: little-endian, doubles bit by bit. A class takes part by
///   template <class Archive> void archive(Archive& archive) { archive(a, b, c); }
/// which serves for both directions.
namespace prehend::simulation {

namespace state_bytes {
template <class T>
constexpr bool kIsPlain = std::is_arithmetic_v<T> || std::is_enum_v<T>;
static_assert(std::endian::native == std::endian::little, "swap bytes here");
}  // namespace state_bytes

/// A vector whose length does not change: reading requires it.
template <class T>
struct OfSameSize {
  std::vector<T>& values;
};
template <class T>
OfSameSize<T> same_size(std::vector<T>& values) {
  return {values};
}

class StateWriter {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <class T>
  void put(const T& value) {
    if constexpr (state_bytes::kIsPlain<T>) {
      bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    } else {
      const_cast<T&>(value).archive(*this);  // which changes nothing but when it reads
    }
  }
  void put(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
  }
  void put(const std::mt19937& random) {
    std::ostringstream text;
    text << random;
    put(text.str());
  }
  template <class Scalar, int rows, int columns>
  void put(const Eigen::Matrix<Scalar, rows, columns>& matrix) {
    for (const Scalar& value : matrix.reshaped()) put(value);
  }
  void put(const Eigen::Quaterniond& q) { put(q.coeffs()); }
  template <class T, std::size_t count>
  void put(const std::array<T, count>& values) {
    for (const T& value : values) put(value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint64_t>(values.size()));
    for (const T& value : values) put(value);
  }
  template <class T>
  void put(const OfSameSize<T>& values) {
    put(values.values);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }

  std::string bytes_;
};

/// @throws geometry::InputError when the bytes end too early or do not fit what is read.
class StateReader {
 public:
  /// `what` names the source in errors, e.g. the file.
  StateReader(std::string_view bytes, std::string what) : left_(bytes), what_(std::move(what)) {}

  template <class... T>
  void operator()(T&&... values) {
    (get(values), ...);
  }
  std::size_t left() const { return left_.size(); }
  [[noreturn]] void fail(const std::string& wrong) const {
    throw geometry::InputError(what_ + " " + wrong, "Save it anew");
  }

 private:
  std::string_view take(std::uint64_t count) {
    if (count > left_.size()) fail("ends in the middle: it was cut off");
    const std::string_view taken = left_.substr(0, count);
    left_.remove_prefix(count);
    return taken;
  }
  template <class T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      const char byte = take(1)[0];
      if (byte != 0 && byte != 1) fail("is damaged: a truth value is neither");
      value = byte != 0;
    } else if constexpr (state_bytes::kIsPlain<T>) {
      std::memcpy(&value, take(sizeof value).data(), sizeof value);
    } else {
      value.archive(*this);
    }
  }
  std::uint64_t count() {
    std::uint64_t value = 0;
    get(value);
    // No element is smaller than a byte: what cannot be there is not made room for.
    if (value > left_.size()) fail("ends in the middle: it was cut off");
    return value;
  }
  void get(std::string& text) { text = std::string(take(count())); }
  void get(std::mt19937& random) {
    std::string text;
    get(text);
    std::istringstream in(text);
    if (!(in >> random)) fail("is damaged: a random generator's state is none");
  }
  template <class Scalar, int rows, int columns>
  void get(Eigen::Matrix<Scalar, rows, columns>& matrix) {
    for (Scalar& value : matrix.reshaped()) get(value);
  }
  void get(Eigen::Quaterniond& q) { get(q.coeffs()); }
  template <class T, std::size_t size>
  void get(std::array<T, size>& values) {
    for (T& value : values) get(value);
  }
  template <class T>
  void get(std::vector<T>& values) {
    values.resize(count());
    for (T& value : values) get(value);
  }
  template <class T>
  void get(OfSameSize<T>& values) {
    if (count() != values.values.size()) fail("is of something of another size");
    for (T& value : values.values) get(value);
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool is_there = false;
    get(is_there);
    if (is_there && !value) value.emplace();
    if (!is_there) value.reset();
    if (value) get(*value);
  }

  std::string_view left_;
  std::string what_;
};

/// FNV-1a, 64 bits: tells accidental damage and other scenes, nothing more.
inline std::uint64_t fingerprint(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) {
    hash ^= static_cast<unsigned char>(byte);
    hash *= 0x100000001b3;
  }
  return hash;
}

}  // namespace prehend::simulation
