#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/parameter.h"

namespace prehend::graph {

/// A node's parameters. All functions may be called from any thread; user code (validate) is called
/// in that thread, outside the lock.
class ParameterStore {
 public:
  /// `given`: name -> text from the command line and parameter files. `sources`: name ->
  /// "FILE:LINE" of those that come from a file, for messages.
  ParameterStore(std::map<std::string, std::string> given,
                 std::map<std::string, std::string> sources)
      : given_(std::move(given)), sources_(std::move(sources)) {}

  /// See Node::declare_parameter.
  ParameterValue declare(ParameterInfo parameter);
  /// The parameter as it is now. Throws std::invalid_argument, with the nearest name, when unknown.
  ParameterInfo get(const std::string& name) const;
  /// Sets all of name -> text, or none and throws as declare and get do; a read-only one can only
  /// be set to what it is. Returns the parameters as they are then, sorted by name.
  std::vector<ParameterInfo> set(const std::map<std::string, std::string>& texts);
  /// True when one of them has a validate(), which is user code.
  bool has_validation(const std::map<std::string, std::string>& texts) const;
  /// Sorted by name.
  std::vector<ParameterInfo> all() const;
  /// True when the command line or a parameter file names it, declared or not.
  bool is_given(const std::string& name) const { return given_.count(name) > 0; }
  /// Throws std::runtime_error when a parameter was given that is not declared.
  void check_all_given_are_declared() const;

 private:
  const ParameterInfo& find(const std::string& name) const;
  std::vector<std::string> names() const;
  /// "FILE:LINE: " or "".
  std::string place_of(const std::string& name) const;

  mutable std::mutex mutex_;
  const std::map<std::string, std::string> given_;
  const std::map<std::string, std::string> sources_;
  std::map<std::string, ParameterInfo> parameters_;
};

/// As it goes over the wire.
msgs::graph::ParameterRecord to_record(const ParameterInfo& parameter);
/// The same back: type, value, default, range and choices, so that parse_parameter() judges a text
/// as the node itself would. What validate() refuses only the node knows.
/// @throws std::invalid_argument for a choice that is not of the parameter's type.
ParameterInfo from_record(const msgs::graph::ParameterRecord& record);

}  // namespace prehend::graph
