#include <volccd/capi/volccd.h>

#include <memory>
#include <string_view>

#include <volccd/capi/arguments.hpp>
#include <volccd/capi/results.hpp>
#include <volccd/core/version.hpp>

struct volccd_detector {
  volccd::Detector detector;
  volccd::capi::Results results = {};
};

namespace volccd::capi {

namespace {

Detector make_detector(std::int64_t vertex_count, const volccd_cells& cells, const volccd_options& options) {
  const DetectorConfig config = config_of(options);
  const auto thickness = thickness_of("cells", cells);
  const Index vertices = vertex_count_of("vertex_count", vertex_count, 0, cells.thickness != nullptr);
  Mesh mesh = mesh_of(vertices, cells_of("cells", cells));
  if (cells.thickness) return Detector(std::move(mesh), thickness, config);
  return Detector(std::move(mesh), config);
}

DetectorEdit edit_of(const Detector& detector, const std::int64_t* removed, std::int64_t removed_count,
                     std::int64_t new_vertices, const volccd_cells* added) {
  DetectorEdit edit;
  const auto ids = array_of("removed", removed, size_of("removed_count", removed_count, sizeof(std::int64_t)));
  edit.removed.assign(ids.begin(), ids.end());
  edit.new_vertices =
      vertex_count_of("new_vertices", new_vertices, detector.mesh().vertex_count(), detector.thickens_shells());
  if (added) {
    edit.added = elements_of(cells_of("added", *added));
    const auto thickness = thickness_of("added", *added);
    edit.thickness.assign(thickness.begin(), thickness.end());
  }
  return edit;
}

/// Runs `step` on the detector and keeps its results; after an exception there are none.
template <class Step>
void run_step(volccd_detector* handle, Step&& step) {
  volccd_detector& d = object_of("detector", handle);
  try {
    step(d.detector);
    fill(d.results, d.detector.result(), d.detector.topology().mesh());
  } catch (...) {
    clear(d.results);
    throw;
  }
}

template <class T>
void give(const std::vector<T>& values, std::size_t values_per_entry, const char* name, const T** out,
          std::int64_t* count) {
  const T*& values_out = object_of(name, out);
  object_of("count", count) = static_cast<std::int64_t>(values.size() / values_per_entry);
  values_out = values.data();
}

}  // namespace

}  // namespace volccd::capi

using namespace volccd;
using namespace volccd::capi;

const char* volccd_version(void) { return VOLCCD_VERSION_STRING; }

int volccd_create(int64_t vertex_count, const volccd_cells* cells, const volccd_options* options,
                  volccd_detector** detector) {
  return guarded([&] {
    volccd_detector*& out = object_of("detector", detector);
    const volccd_options defaults{};
    out = std::make_unique<volccd_detector>(
              volccd_detector{make_detector(vertex_count, object_of("cells", cells), options ? *options : defaults)})
              .release();
  });
}

void volccd_free(volccd_detector* detector) { delete detector; }

int volccd_edit(volccd_detector* detector, const int64_t* removed, int64_t removed_count, int64_t new_vertices,
                const volccd_cells* added) {
  return guarded([&] {
    Detector& d = object_of("detector", detector).detector;
    d.edit(edit_of(d, removed, removed_count, new_vertices, added));
  });
}

int volccd_size(const volccd_detector* detector, int64_t* vertex_count, int64_t* element_count) {
  return guarded([&] {
    const Mesh& mesh = object_of("detector", detector).detector.mesh();
    if (vertex_count) *vertex_count = mesh.vertex_count();
    if (element_count) *element_count = mesh.element_count();
  });
}

int volccd_set_separation(volccd_detector* detector, double separation) {
  return guarded([&] { object_of("detector", detector).detector.set_separation(separation); });
}

int volccd_guarantee(const volccd_detector* detector, const char** guarantee) {
  return guarded([&] {
    const Pipeline& pipeline = object_of("detector", detector).detector.pipeline();
    object_of("guarantee", guarantee) = to_string(pipeline.guarantee());
  });
}

int volccd_step(volccd_detector* detector, int64_t vertex_count, const double* x0, const double* x1, int32_t flags,
                double t_max) {
  return guarded([&] {
    run_step(detector, [&](Detector& d) {
      const std::size_t n = size_of("vertex_count", vertex_count, sizeof(Vec3));
      d.step(points_of("x0", x0, n), points_of("x1", x1, n), request_of(flags), t_max);
    });
  });
}

int volccd_step_quadratic(volccd_detector* detector, int64_t vertex_count, const double* x0, const double* xm,
                          const double* x1, int32_t flags, double t_max) {
  return guarded([&] {
    run_step(detector, [&](Detector& d) {
      const std::size_t n = size_of("vertex_count", vertex_count, sizeof(Vec3));
      d.step(points_of("x0", x0, n), points_of("xm", xm, n), points_of("x1", x1, n), request_of(flags), t_max);
    });
  });
}

int volccd_contacts(const volccd_detector* detector, const volccd_contact** contacts, int64_t* count) {
  return guarded([&] { give(object_of("detector", detector).results.contacts, 1, "contacts", contacts, count); });
}

int volccd_contact_ends(const volccd_detector* detector, const volccd_contact_end** ends, int64_t* count) {
  return guarded([&] { give(object_of("detector", detector).results.ends, 1, "ends", ends, count); });
}

int volccd_initial_overlaps(const volccd_detector* detector, const int64_t** pairs, int64_t* count) {
  return guarded([&] { give(object_of("detector", detector).results.initial_overlaps, 2, "pairs", pairs, count); });
}

int volccd_first(volccd_detector* detector, int64_t vertex_count, const double* x0, const double* x1,
                 volccd_contact* contact, int32_t* found) {
  return guarded([&] {
    volccd_contact& earliest = object_of("contact", contact);
    std::int32_t& is_found = object_of("found", found);
    run_step(detector, [&](Detector& d) {
      const std::size_t n = size_of("vertex_count", vertex_count, sizeof(Vec3));
      d.step(points_of("x0", x0, n), points_of("x1", x1, n), {.query = Query::first});
    });
    const auto& contacts = detector->results.contacts;
    if (!contacts.empty()) earliest = contacts.front();
    is_found = contacts.empty() ? 0 : 1;
  });
}

int volccd_statistics(const volccd_detector* detector, const volccd_statistic** entries, int64_t* count) {
  return guarded([&] { give(object_of("detector", detector).results.statistics, 1, "entries", entries, count); });
}

int volccd_statistic_value(const volccd_detector* detector, const char* name, double* value) {
  return guarded([&] {
    const auto& statistics = object_of("detector", detector).results.statistics;
    const std::string_view wanted(&object_of("name", name));
    double& out = object_of("value", value);
    for (const volccd_statistic& entry : statistics)
      if (entry.name == wanted) {
        out = entry.value;
        return;
      }
    throw ArgumentError(fmt::format("name: the last step has no statistic '{}'", wanted));
  });
}
