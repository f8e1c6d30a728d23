// Arrays and detectors for tests of the C interface.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <volccd.h>

#include <volccd/oracle/cases/shapes.hpp>

#include "support/two_bodies.hpp"

namespace volccd::capi_test {

/// The elements of a shape as arrays, with ids 100, 101, ... in their order.
class Arrays {
 public:
  explicit Arrays(const Shape& shape) : Arrays(shape.elements) {
    for (std::size_t i = 0; i < ids_.size(); ++i) ids_[i] = 100 + static_cast<std::int64_t>(i);
  }
  explicit Arrays(const std::vector<ElementSpec>& elements) {
    for (const ElementSpec& element : elements) {
      types_.push_back(static_cast<std::uint8_t>(element.type));
      connectivity_.insert(connectivity_.end(), element.vertices.begin(), element.vertices.end());
      faces_.insert(faces_.end(), element.faces.begin(), element.faces.end());
      offsets_.push_back(static_cast<std::int64_t>(connectivity_.size()));
      face_offsets_.push_back(static_cast<std::int64_t>(faces_.size()));
      ids_.push_back(element.id);
      objects_.push_back(element.object);
    }
  }

  volccd_cells cells() const {
    volccd_cells cells{};
    cells.count = static_cast<std::int64_t>(types_.size());
    cells.types = types_.data();
    cells.offsets = offsets_.data();
    cells.connectivity = connectivity_.data();
    cells.connectivity_size = static_cast<std::int64_t>(connectivity_.size());
    cells.ids = ids_.data();
    cells.objects = objects_.data();
    cells.face_offsets = face_offsets_.data();
    cells.faces = faces_.data();
    cells.faces_size = static_cast<std::int64_t>(faces_.size());
    return cells;
  }
  std::size_t size() const { return types_.size(); }
  std::vector<std::int64_t>& ids() { return ids_; }

 private:
  std::vector<std::uint8_t> types_;
  std::vector<std::int64_t> offsets_ = {0}, connectivity_, ids_, face_offsets_ = {0}, faces_;
  std::vector<std::int32_t> objects_;
};

struct Free {
  void operator()(volccd_detector* detector) const { volccd_free(detector); }
};
using Handle = std::unique_ptr<volccd_detector, Free>;

inline Handle create(std::size_t vertices, const volccd_cells& cells, const volccd_options& options = {}) {
  volccd_detector* detector = nullptr;
  const int code = volccd_create(static_cast<std::int64_t>(vertices), &cells, &options, &detector);
  if (code != VOLCCD_OK) throw std::runtime_error(volccd_last_error());
  return Handle(detector);
}

inline const double* values(const std::vector<Vec3>& points) { return points.data()->data(); }
inline std::int64_t count(const std::vector<Vec3>& points) { return static_cast<std::int64_t>(points.size()); }

/// An array of results, by one of the functions volccd_contacts, ...
template <class T>
std::vector<T> take(int (*function)(const volccd_detector*, const T**, std::int64_t*), const Handle& detector,
                    std::int64_t values_per_entry = 1) {
  const T* data = nullptr;
  std::int64_t n = -1;
  if (function(detector.get(), &data, &n) != VOLCCD_OK) throw std::runtime_error(volccd_last_error());
  return std::vector<T>(data, data + n * values_per_entry);
}

inline Shape two_of(const Shape& shape) { return test::two_bodies(shape, 0.2); }

}  // namespace volccd::capi_test
