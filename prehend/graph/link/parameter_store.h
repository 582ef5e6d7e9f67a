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

/// A node's parameters. All functions may be called from any thread; none calls back.
class ParameterStore {
 public:
  /// `given`: name -> text from the command line and parameter files.
  explicit ParameterStore(std::map<std::string, std::string> given) : given_(std::move(given)) {}

  /// See Node::declare_parameter.
  ParameterValue declare(ParameterInfo parameter);
  /// The parameter as it is now. Throws std::invalid_argument, with the nearest name, when unknown.
  ParameterInfo get(const std::string& name) const;
  /// Sets and returns it as it is then. Throws as declare and get do.
  ParameterInfo set(const std::string& name, const std::string& text);
  /// Sorted by name.
  std::vector<ParameterInfo> all() const;
  /// Throws std::runtime_error when a parameter was given that is not declared.
  void check_all_given_are_declared() const;

 private:
  const ParameterInfo& find(const std::string& name) const;
  std::vector<std::string> names() const;

  mutable std::mutex mutex_;
  std::map<std::string, std::string> given_;
  std::map<std::string, ParameterInfo> parameters_;
};

/// As it goes over the wire.
msgs::graph::ParameterRecord to_record(const ParameterInfo& parameter);

}  // namespace prehend::graph
