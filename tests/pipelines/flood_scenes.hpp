// Scenes that a flood may lose contacts in.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <volccd/core/random.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::test {

struct FloodScene {
  Topology topology;
  Motion linear, quadratic;
  std::string what;
};

/// Random meshes and motions that fold, invert, crush, roll up, nest and tear.
class FloodScenes {
 public:
  explicit FloodScenes(std::uint64_t seed) : random_(seed) {}

  FloodScene make() {
    what_.clear();
    deep_ = one_in(3);
    const Shape shape = permuted(several_objects(), random_.next());
    const std::vector<Vec3> x0 = deep_ ? near(shape.positions) : moved(shape.positions);
    const std::vector<Vec3> x1 = deep_ || one_in(4) ? near(x0) : moved(shape.positions);
    std::vector<Vec3> middle(x0.size());
    for (std::size_t v = 0; v < x0.size(); ++v) middle[v] = (x0[v] + x1[v]) / 2;
    middle = jittered(middle, one_in(2) ? 0.05 : 0.4, random_.next());
    return {Topology(shape.mesh()), Motion::linear(x0, x1), Motion::quadratic(x0, middle, x1), what_};
  }

 private:
  bool one_in(std::uint64_t n) { return random_.below(n) == 0; }
  void note(const std::string& text) { what_ += (what_.empty() ? "" : ", ") + text; }

  Shape one_object() {
    constexpr std::array types = {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge,
                                  ElementType::pyramid,     ElementType::polytope,   ElementType::triangle,
                                  ElementType::quad};
    const int n = deep_ ? 5 : one_in(3) ? 3 : 2;
    if (deep_) return note("large"), block(types[random_.below(4)], n, n, n - 1);
    if (one_in(6)) return note("mixed"), mixed_block(n - 1, n);
    const ElementType type = types[one_in(5) ? random_.below(types.size()) : random_.below(4)];
    note(to_string(type));
    return block(type, n, n + static_cast<int>(random_.below(2)), is_shell(type) ? 1 : n);
  }

  Shape several_objects() {
    Shape all = one_object();
    if (one_in(2)) {
      Shape other = one_object();
      const bool nested = one_in(2);
      const Vec3 by(random_.uniform(0, 2), random_.uniform(0, 2), random_.uniform(0, 2));
      const double size = nested ? 0.2 : random_.uniform(0.4, 1), turn = one_in(2) ? 1 : -1;
      note(nested ? "nested" : "into another");
      for (Vec3& p : other.positions) p = Vec3(size * p.x(), turn * size * p.y(), turn * size * p.z()) + by;
      all.append(other, 2);
    }
    if (one_in(3)) join_somewhere(all);
    if (one_in(3)) add_leaves(all);
    if (one_in(2)) tear(all);
    return all;
  }

  /// Elements are removed, so that the rest is connected by edges or vertices only, or not at all.
  void tear(Shape& shape) {
    const double share = random_.uniform(0.05, 0.6);
    std::erase_if(shape.elements,
                  [&](const ElementSpec&) { return shape.elements.size() > 4 && random_.uniform() < share; });
    note("torn");
  }

  /// Adds tetrahedra on faces of others, also inside, where a face then has three.
  void add_leaves(Shape& shape) {
    std::vector<std::size_t> tetrahedra;
    for (std::size_t i = 0; i < shape.elements.size(); ++i)
      if (shape.elements[i].type == ElementType::tetrahedron) tetrahedra.push_back(i);
    if (tetrahedra.empty()) return;
    note("leaves");
    for (std::int64_t i = 0; i < 5; ++i) {
      ElementSpec leaf = shape.elements[tetrahedra[random_.below(tetrahedra.size())]];
      const std::size_t corner = random_.below(4);
      leaf.id = 1000000 + i;
      const Vec3 apart(random_.uniform(-1, 1), random_.uniform(-1, 1), random_.uniform(-1, 1));
      shape.positions.push_back(shape.positions[leaf.vertices[corner]] + apart);
      leaf.vertices[corner] = static_cast<Index>(shape.positions.size() - 1);
      shape.elements.push_back(leaf);
    }
  }

  /// Identifies vertices of two elements.
  void join_somewhere(Shape& shape) {
    for (int i = 0; i < 3; ++i) {
      const Index a = static_cast<Index>(random_.below(shape.positions.size()));
      const Index b = static_cast<Index>(random_.below(shape.positions.size()));
      const bool safe = std::none_of(shape.elements.begin(), shape.elements.end(), [&](const ElementSpec& e) {
        const auto has = [&](Index v) {
          return std::find(e.vertices.begin(), e.vertices.end(), v) != e.vertices.end();
        };
        return has(a) && has(b);
      });
      if (!safe || a == b) continue;
      for (ElementSpec& e : shape.elements) e.renumber([&](Index v) { return v == a ? b : v; });
      note("joined");
    }
  }

  std::vector<Vec3> near(const std::vector<Vec3>& from) { return jittered(from, deep_ ? 0.1 : 0.01, random_.next()); }

  std::vector<Vec3> moved(std::vector<Vec3> x) {
    for (std::uint64_t i = random_.below(3); i > 0; --i) deform(x);
    constexpr std::array amounts = {0.0, 0.02, 0.15, 0.45};
    const double amount = amounts[random_.below(amounts.size())];
    if (amount > 0) x = jittered(x, amount, random_.next());
    note("jitter " + std::to_string(amount));
    return x;
  }

  void deform(std::vector<Vec3>& x) {
    const std::uint64_t kind = random_.below(7);
    const double turns = random_.uniform(0.1, 1.4), pivot = random_.uniform(0.2, 1.5);
    const Vec3 target(random_.uniform(0, 2), random_.uniform(0, 2), random_.uniform(0, 2));
    constexpr std::array names = {"roll", "twist", "mirror", "crush", "turn inside out", "fold", "pull a vertex"};
    note(names[kind]);
    if (kind == 6) {
      x[random_.below(x.size())] = target;
      return;
    }
    for (Vec3& p : x) p = deformed(p, kind, turns, pivot, target);
  }

  static Vec3 deformed(const Vec3& p, std::uint64_t kind, double turns, double pivot, const Vec3& target) {
    const double angle = 2 * std::numbers::pi * turns;
    switch (kind) {
      case 0:
        return {(pivot + p.z()) * std::sin(angle * p.x() / 3), p.y(), (pivot + p.z()) * std::cos(angle * p.x() / 3)};
      case 1: {
        const double a = angle * p.z() / 3, x = p.x() - 1, y = p.y() - 1;
        return {std::cos(a) * x - std::sin(a) * y, std::sin(a) * x + std::cos(a) * y, p.z()};
      }
      case 2: return {-p.x(), p.y(), p.z()};
      case 3: return {p.x(), p.y(), p.z() * (pivot - 0.5) / 5};
      case 4: return target - (p - target) * turns;
      default: return {p.x() < pivot ? p.x() : 2 * pivot - p.x(), p.y(), p.z()};
    }
  }

  Random random_;
  bool deep_ = false;  ///< large meshes with small deformations, inside each other
  std::string what_;
};

}  // namespace volccd::test
