#include <volccd/simulation/elements/pressure_forces.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>

namespace volccd::simulation {
namespace {

/// Triangles or vertices in a chunk; the power is summed by chunks of vertices.
constexpr std::size_t kGrain = 2048;

void check_load(const Pressure& load, std::size_t index, std::size_t bodies) {
  const auto require = [&](bool good, const char* problem) {
    if (!good) throw InputError("model", "pressures", static_cast<std::int64_t>(index), problem);
  };
  require(load.object >= 0 && static_cast<std::size_t>(load.object) < bodies, "acts on a body that does not exist");
  require(!load.curve.empty(), "has no curve");
  for (std::size_t i = 0; i < load.curve.size(); ++i) {
    const auto& [time, pressure] = load.curve[i];
    require(std::isfinite(time) && std::isfinite(pressure), "has a curve that is not finite");
    require(i == 0 || load.curve[i - 1].first < time, "has a curve that does not ascend in time");
  }
}

}  // namespace

double pressure_at(const Pressure& load, double time) {
  const auto& curve = load.curve;
  const auto after =
      std::upper_bound(curve.begin(), curve.end(), time, [](double t, const auto& p) { return t < p.first; });
  if (after == curve.begin()) return curve.front().second;
  if (after == curve.end()) return curve.back().second;
  const auto& [t0, p0] = after[-1];
  const auto& [t1, p1] = *after;
  return p0 + (p1 - p0) * ((time - t0) / (t1 - t0));
}

PressureForces::PressureForces(const Model& model) : loads_(model.pressures), pressure_(loads_.size()) {
  for (std::size_t i = 0; i < loads_.size(); ++i) check_load(loads_[i], i, model.bodies.size());
  update(model.mesh);
}

void PressureForces::update(const Mesh& mesh) {
  triangles_.clear();
  vertices_.clear();
  offsets_.assign(1, 0);
  std::vector<Index> count(mesh.vertex_count(), 0);
  for (Index load = 0; load < loads_.size(); ++load) {
    for (Index slot = 0; slot < mesh.element_slots(); ++slot) {
      if (mesh.type(slot) != ElementType::triangle || mesh.object(slot) != loads_[load].object) continue;
      const auto v = mesh.vertices(slot);
      triangles_.push_back({{v[0], v[1], v[2]}, load});
      for (const Index vertex : v) ++count[vertex];
    }
  }
  std::vector<Index> cursor(mesh.vertex_count(), 0);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (count[v] == 0) continue;
    cursor[v] = offsets_.back();
    vertices_.push_back(v);
    offsets_.push_back(offsets_.back() + count[v]);
  }
  incidence_.resize(offsets_.back());
  for (Index i = 0; i < triangles_.size(); ++i) {
    for (const Index v : triangles_[i].vertices) incidence_[cursor[v]++] = i;
  }
  shares_.resize(triangles_.size());
  block_power_.resize((vertices_.size() + kGrain - 1) / kGrain);
}

double PressureForces::add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double time, Executor& executor,
                                  std::span<Vec3> force) {
  if (empty()) return 0;
  for (std::size_t i = 0; i < loads_.size(); ++i) pressure_[i] = pressure_at(loads_[i], time);
  executor.parallel_for(triangles_.size(), kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& [t, load] = triangles_[i];
      shares_[i] = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]) * (pressure_[load] / 6);
    }
  });
  executor.parallel_for(block_power_.size(), 1, [&](std::size_t first, std::size_t last, unsigned) {
    for (std::size_t block = first; block < last; ++block) {
      double power = 0;
      for (std::size_t i = block * kGrain; i < std::min(vertices_.size(), (block + 1) * kGrain); ++i) {
        Vec3 sum = Vec3::Zero();
        for (Index k = offsets_[i]; k < offsets_[i + 1]; ++k) sum += shares_[incidence_[k]];
        force[vertices_[i]] += sum;
        power += sum.dot(v[vertices_[i]]);
      }
      block_power_[block] = power;
    }
  });
  double power = 0;
  for (const double p : block_power_) power += p;
  return power;
}

}  // namespace volccd::simulation
