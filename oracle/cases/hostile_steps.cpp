// Edits and motions of hostile meshes.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <volccd/oracle/cases/hostile_parts.hpp>

namespace volccd::cases {
namespace {

using Positions = std::vector<Vec3>;

/// Displaces the moving vertices. Most displacements are small or of few vertices, because nearly all stars are suspect
/// otherwise, and little remains to be lost; `wild` displacements are large.
class Deformer {
 public:
  Deformer(Choices& choices, const HostileMesh& mesh, const std::vector<ElementSpec>& live, Index vertices, bool wild)
      : c_(choices), mesh_(mesh), live_(live), vertices_(vertices), wild_(wild) {}

  Positions apply(const Positions& from, std::string& what) {
    Positions x = from;
    constexpr const char* kNames[] = {"calm",   "pose", "pulled", "jitter", "rigid", "rest", "deformed or jitter",
                                      "swapped"};
    constexpr int kCalmKinds[] = {0, 0, 1, 2, 2, 2, 3, 4};
    const int kind = wild_ ? c_.below(8) : kCalmKinds[c_.below(8)];
    what += std::string(what.empty() ? "" : ", ") + kNames[kind];
    switch (kind) {
      case 1: to_pose(x, c_.below(static_cast<int>(mesh_.poses.size()) + 1)); break;
      case 2: pull(x); break;
      case 3: jitter(x, static_cast<int>(wild_ ? c_.pick({8, 16, 32}) : c_.pick({4, 5, 6}))); break;
      case 4: move_part(x); break;
      case 5: to_pose(x, 0); break;
      case 6: c_.one_in(4) ? deform(x) : jitter(x, 8); break;
      case 7: std::swap(x[any_moving()], x[any_moving()]); break;
      default: break;
    }
    jitter(x, static_cast<int>(c_.pick({0, 1, 1, 3})));
    return x;
  }

 private:
  Index any_moving() { return static_cast<Index>(c_.below(static_cast<int>(mesh_.moving))); }
  bool moves(Index v) const { return v < mesh_.moving || v >= mesh_.shape.positions.size(); }

  void jitter(Positions& x, int amount) {
    if (amount == 0) return;
    for (Index v = 0; v < vertices_; ++v)
      if (moves(v)) x[v] += lattice_point(c_, amount);
  }

  void to_pose(Positions& x, int which) {
    const Positions& pose = which == 0 ? mesh_.shape.positions : mesh_.poses[static_cast<std::size_t>(which - 1)];
    std::copy(pose.begin(), pose.end(), x.begin());
  }

  void pull(Positions& x) {
    const int count = 1 + c_.below(2);
    for (int i = 0; i < count; ++i) {
      const Index v = mesh_.pulled.empty() || c_.one_in(4) ? any_moving() : one_of(c_, mesh_.pulled);
      const bool to_another = c_.one_in(4);
      x[v] = (to_another ? x[any_moving()] : x[v]) + lattice_point(c_, static_cast<int>(c_.pick({8, 16, 40})));
    }
  }

  /// Moves the vertices of an object, or of a half-space.
  void move_part(Positions& x) {
    const Vec3 by = lattice_point(c_, static_cast<int>(wild_ ? c_.pick({16, 64}) : c_.pick({4, 16})));
    std::vector<bool> part(x.size(), false);
    if (c_.below(2)) {
      const std::int32_t object = c_.below(3);
      for (const ElementSpec& e : live_)
        if (e.object == object)
          for (const Index v : e.vertices) part[v] = true;
    } else {
      const Vec3 normal = lattice_point(c_, 2), origin = x[any_moving()];
      for (std::size_t v = 0; v < x.size(); ++v) part[v] = normal.dot(x[v] - origin) > 0;
    }
    for (Index v = 0; v < vertices_; ++v)
      if (part[v] && moves(v)) x[v] += by;
  }

  void deform(Positions& x) {
    const int kind = c_.below(6);
    const double turns = (1 + c_.below(16)) / 12.0;
    const Vec3 pivot = x[any_moving()];
    for (Index v = 0; v < vertices_; ++v)
      if (moves(v)) x[v] = rounded(pivot + deformed(x[v] - pivot, kind, turns));
  }

  /// Does not crush the mesh so far that everything touches everything, which would take seconds to decide.
  static Vec3 deformed(const Vec3& p, int kind, double turns) {
    constexpr double kLength = 3 * kCellWidth;
    const double full = 2 * std::numbers::pi * turns;
    switch (kind) {
      case 0: {  // roll
        const double angle = full * p.x() / kLength, radius = kCellWidth + p.z();
        return {radius * std::sin(angle), p.y(), radius * std::cos(angle) - kCellWidth};
      }
      case 1: {  // twist
        const double angle = full * p.z() / kLength, cos = std::cos(angle), sin = std::sin(angle);
        return {cos * p.x() - sin * p.y(), sin * p.x() + cos * p.y(), p.z()};
      }
      case 2: return {-p.x(), p.y(), p.z()};                                // mirror
      case 3: return {p.x(), p.y(), p.z() * (turns < 0.7 ? 0.25 : -0.25)};  // crush, perhaps beyond the plane
      case 4: return -(0.5 + turns / 2) * p;                                // turn inside out
      default: return {-std::abs(p.x()), p.y(), p.z()};                     // fold
    }
  }

  Choices& c_;
  const HostileMesh& mesh_;
  const std::vector<ElementSpec>& live_;
  Index vertices_;
  bool wild_;
};

/// A mesh in the course of the steps.
class Course {
 public:
  Course(HostileMesh mesh, Choices& choices) : c_(choices), mesh_(std::move(mesh)) {
    live_ = mesh_.shape.elements;
    x_ = mesh_.shape.positions;
    for (const ElementSpec& e : live_) next_id_ = std::max(next_id_, e.id + 1);
  }

  Mesh mesh() const { return mesh_.shape.mesh(); }
  const std::string& what() const { return mesh_.what; }

  void edit(HostileStep& step) {
    const int kind = c_.below(3);
    if (kind == 0) gone_.empty() ? remove_some(step) : add_again(step);
    if (kind == 1) mesh_.cells.empty() ? remove_some(step) : refill_cell(step);
    if (kind == 2) attach(step);
    for (ElementSpec& spec : step.added) spec.id = next_id_++;
    live_.insert(live_.end(), step.added.begin(), step.added.end());
  }

  void move(HostileStep& step, bool quadratic) {
    Deformer deformer(c_, mesh_, live_, static_cast<Index>(x_.size()), c_.one_in(8));
    if (c_.one_in(4)) {
      step.what += step.what.empty() ? "jump" : ", jump";
      x_ = deformer.apply(x_, step.what);
    }
    const Positions start = x_;
    x_ = deformer.apply(start, step.what);
    if (!quadratic) {
      step.motion = Motion::linear(start, x_);
      return;
    }
    Positions middle(x_.size());
    const int range = static_cast<int>(c_.pick({0, 2, 4, 32}));
    for (std::size_t v = 0; v < x_.size(); ++v) {
      middle[v] = (start[v] + x_[v]) / 2;
      if (v < mesh_.moving || v >= mesh_.shape.positions.size()) middle[v] += lattice_point(c_, range);
    }
    step.motion = Motion::quadratic(start, middle, x_);
  }

 private:
  void remove(HostileStep& step, auto&& which) {
    std::vector<ElementSpec> kept;
    for (ElementSpec& e : live_) {
      if (which(e)) {
        step.removed.push_back(e.id);
        gone_.push_back(std::move(e));
      } else {
        kept.push_back(std::move(e));
      }
    }
    live_ = std::move(kept);
  }

  void remove_some(HostileStep& step) {
    const int share = between(c_, 2, 12);
    std::size_t left = live_.size();
    remove(step, [&](const ElementSpec&) { return c_.below(share) == share - 1 && left > 1 && left--; });
    step.what = "removed " + std::to_string(step.removed.size());
  }

  void add_again(HostileStep& step) {
    step.added = std::exchange(gone_, {});
    step.what = "added again " + std::to_string(step.added.size());
  }

  /// Replaces the elements inside a cell by others with the same corners.
  void refill_cell(HostileStep& step) {
    const std::array<Index, 8> cell = one_of(c_, mesh_.cells);
    const auto in_cell = [&](Index v) { return std::find(cell.begin(), cell.end(), v) != cell.end(); };
    std::vector<ElementSpec> gone = std::exchange(gone_, {});
    remove(step, [&](const ElementSpec& e) {
      return !is_shell(e.type) && std::count_if(e.vertices.begin(), e.vertices.end(), in_cell) >= 4;
    });
    gone_ = std::move(gone);  // what this removes is not added again
    const auto filling = static_cast<CellFilling>(c_.below(6));
    Index centre = 0;
    if (filling == CellFilling::pyramids) {
      Vec3 sum = Vec3::Zero();
      for (const Index v : cell) sum += x_[v];
      centre = new_vertex(step, rounded(sum / 8));
    }
    step.added = fill_cell(cell, filling, c_.below(24), centre);
    step.what = "refilled a cell";
  }

  /// Adds an element of any type with some vertices of another element, and new ones.
  void attach(HostileStep& step) {
    constexpr ElementType kTypes[] = {ElementType::tetrahedron, ElementType::hexahedron, ElementType::triangle,
                                      ElementType::pyramid,     ElementType::wedge,      ElementType::quad};
    const ElementType type = kTypes[c_.below(6)];
    const auto count = static_cast<std::size_t>(vertex_count(type));
    ElementSpec made{.type = type, .vertices = one_of(c_, live_).vertices, .object = c_.below(2)};
    made.vertices.resize(std::min({made.vertices.size(), count - 1, static_cast<std::size_t>(between(c_, 1, 4))}));
    const Vec3 near = x_[made.vertices[0]];
    while (made.vertices.size() < count)
      made.vertices.push_back(new_vertex(step, near + lattice_point(c_, kCellWidth)));
    step.added.push_back(std::move(made));
    step.what = std::string("added a ") + to_string(type);
  }

  Index new_vertex(HostileStep& step, const Vec3& at) {
    ++step.new_vertices;
    x_.push_back(at);
    return static_cast<Index>(x_.size() - 1);
  }

  Choices& c_;
  HostileMesh mesh_;
  std::vector<ElementSpec> live_, gone_;
  Positions x_;
  std::int64_t next_id_ = 0;
};

ObjectFilter any_filter(Choices& c) {
  switch (c.below(10)) {
    case 6: return ObjectFilter(PairScope::intra);
    case 7: return ObjectFilter(PairScope::inter);
    case 8: {
      ObjectFilter filter;
      filter.exclude(0, 0);
      return filter;
    }
    case 9: {
      ObjectFilter filter;
      filter.exclude(0, c.below(3));
      filter.exclude(1, 2);
      return filter;
    }
    default: return {};
  }
}

/// Properties that all steps of a case have, so that the flood can reuse what it has learnt, or each of its own.
struct CaseChoice {
  double separation;
  bool quadratic;
};

HostileCase with_steps(Choices& c, std::string name, std::vector<HostileMesh> meshes) {
  HostileCase made;
  made.name = std::move(name);
  std::vector<Course> courses;
  for (HostileMesh& mesh : meshes) {
    courses.emplace_back(std::move(mesh), c);
    made.meshes.push_back(courses.back().mesh());
    made.name += (courses.size() > 1 ? " | " : ": ") + courses.back().what();
  }
  const CaseChoice all{c.below(2) ? c.pick({0.1, 0.7, 2.3}) : 0, c.one_in(6)};
  for (int k = between(c, 1, 4) + 2 * static_cast<int>(courses.size() - 1); k > 0; --k) {
    HostileStep& step = made.steps.emplace_back();
    step.mesh = static_cast<std::size_t>(c.below(static_cast<int>(courses.size())));
    step.separation = c.one_in(8) ? c.pick({0, 0.7, 2.3}) : all.separation;
    if (c.one_in(4)) courses[step.mesh].edit(step);
    courses[step.mesh].move(step, all.quadratic != c.one_in(8));
    step.t_max = c.one_in(4) ? (1 + c.below(8)) / 8.0 : 1;
    step.filter = any_filter(c);
    step.first_only = c.one_in(8);
    step.initial_overlaps = c.one_in(3);
  }
  return made;
}

std::vector<std::vector<Vec3>*> all_positions(HostileMesh& mesh) {
  std::vector<std::vector<Vec3>*> all = {&mesh.shape.positions};
  for (auto& pose : mesh.poses) all.push_back(&pose);
  return all;
}

HostileMesh finished(Choices& c, const HostileFamily& family) {
  HostileMesh mesh = family.make(c);
  if (c.one_in(6)) reverse_some(c, mesh);
  if (c.one_in(8)) tear(c, mesh);
  if (c.one_in(3)) assign_objects(c, mesh);
  remove_unused_vertices(mesh);
  if (mesh.moving == 0) mesh.moving = static_cast<Index>(mesh.shape.positions.size());  // what moved is torn off
  const int range = c.one_in(5) ? 0 : between(c, 1, 4);                                 // mostly in general position
  for (std::vector<Vec3>* x : all_positions(mesh))
    for (Vec3& p : *x) p += lattice_point(c, range);
  if (c.one_in(24)) append_calm_block(mesh, 4);
  if (c.below(2)) permute(c, mesh);
  return mesh;
}

}  // namespace

HostileCase make_hostile(Choices& c, const HostileFamily& family) {
  return with_steps(c, family.name, {finished(c, family)});
}

HostileCase make_hostile(Choices& c) {
  const auto any_family = [&]() -> const HostileFamily& {
    const auto families = hostile_families();
    return families[static_cast<std::size_t>(c.below(static_cast<int>(families.size())))];
  };
  if (!c.one_in(6)) return make_hostile(c, any_family());
  std::vector<HostileMesh> meshes;
  for (int i = between(c, 2, 3); i > 0; --i) meshes.push_back(finished(c, any_family()));
  return with_steps(c, "several meshes", std::move(meshes));
}

}  // namespace volccd::cases
