#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::geometry {

/// What is made of meshes at some cost, kept while the meshes are in use: links of one file share
/// one, and robots are prepared anew for each posture, plan or thread. May be asked by several
/// threads at once; two may then make the same.
template <class Value>
class KeptByMesh {
 public:
  using Mesh = std::shared_ptr<const TriangleMesh>;

  /// make(*mesh, parameter), or what it gave before. @param make a function of these alone
  template <class Make>
  Value of(const Mesh& mesh, double parameter, const Make& make) {
    const Key key{mesh.get(), parameter};
    {
      const std::lock_guard lock(mutex_);
      const auto found = kept_.find(key);
      // Another mesh may have come to lie where one was.
      if (found != kept_.end() && found->second.mesh.lock() == mesh) return found->second.value;
    }
    Value value = make(*mesh, parameter);
    const std::lock_guard lock(mutex_);
    std::erase_if(kept_, [](const auto& entry) { return entry.second.mesh.expired(); });
    kept_[key] = {mesh, value};
    return value;
  }

 private:
  using Key = std::pair<const TriangleMesh*, double>;
  struct Kept {
    std::weak_ptr<const TriangleMesh> mesh;
    Value value;
  };
  std::mutex mutex_;
  std::map<Key, Kept> kept_;
};

}  // namespace prehend::geometry
