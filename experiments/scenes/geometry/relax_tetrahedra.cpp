#include <volccd/experiments/scenes/geometry/relax_tetrahedra.hpp>

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <volccd/core/sort_unique.hpp>

namespace volccd {

namespace {

constexpr int kRounds = 6;
constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

class Relaxation {
 public:
  Relaxation(const ImplicitSolid& solid, std::vector<Vec3>& positions,
             const std::vector<std::array<Index, 4>>& tetrahedra)
      : solid_(solid),
        x_(positions),
        tetrahedra_(tetrahedra),
        tetrahedra_at_(x_.size()),
        near_(x_.size()),
        surface_(x_.size(), false) {
    std::vector<std::array<Index, 3>> faces;
    for (Index t = 0; t < tetrahedra.size(); ++t) {
      for (const Index v : tetrahedra[t]) tetrahedra_at_[v].push_back(t);
      for (const auto& f : kFaces) {
        std::array<Index, 3> face = {tetrahedra[t][f[0]], tetrahedra[t][f[1]], tetrahedra[t][f[2]]};
        std::sort(face.begin(), face.end());
        faces.push_back(face);
      }
    }
    std::sort(faces.begin(), faces.end());
    for (std::size_t i = 0; i < faces.size(); ++i)
      if ((i == 0 || faces[i - 1] != faces[i]) && (i + 1 == faces.size() || faces[i + 1] != faces[i])) join(faces[i]);
    for (Index t = 0; t < tetrahedra.size(); ++t)
      for (const Index v : tetrahedra[t])
        if (!surface_[v])
          for (const Index w : tetrahedra[t])
            if (w != v) near_[v].push_back(w);
    for (std::vector<Index>& list : near_) sort_unique(list);
  }

  void round() {
    for (Index v = 0; v < x_.size(); ++v) {
      if (near_[v].empty()) continue;
      Vec3 middle = Vec3::Zero();
      for (const Index w : near_[v]) middle += x_[w];
      middle /= static_cast<double>(near_[v].size());
      const Vec3 old = x_[v];
      const double flattest = smallest_altitude(v);
      for (const double share : {1.0, 0.5, 0.25, 0.1}) {
        x_[v] = old + share * (middle - old);
        if (surface_[v]) x_[v] = on_surface(x_[v], (middle - old).norm());
        if (smallest_altitude(v) > flattest) break;
        x_[v] = old;
      }
    }
  }

 private:
  void join(const std::array<Index, 3>& face) {
    for (std::size_t i = 0; i < 3; ++i) {
      surface_[face[i]] = true;
      near_[face[i]].push_back(face[(i + 1) % 3]);
      near_[face[i]].push_back(face[(i + 2) % 3]);
    }
  }

  /// Projects a point onto the surface by Newton's method along the gradient. The gradient is computed from differences
  /// over a small fraction of `length`.
  Vec3 on_surface(Vec3 p, double length) const {
    const double h = 1e-3 * length;
    for (int i = 0; i < 3 && h > 0; ++i) {
      const double value = solid_.value(p);
      Vec3 slope;
      for (int c = 0; c < 3; ++c) slope[c] = (solid_.value(p + h * Vec3::Unit(c)) - value) / h;
      if (!(slope.squaredNorm() > 0)) break;
      p -= value / slope.squaredNorm() * slope;
    }
    return p;
  }

  /// The smallest altitude of the tetrahedra at v; negative if one of them is inverted.
  double smallest_altitude(Index v) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Index t : tetrahedra_at_[v]) {
      const auto& [a, b, c, d] = tetrahedra_[t];
      const double volume = (x_[b] - x_[a]).cross(x_[c] - x_[a]).dot(x_[d] - x_[a]);
      double area = 0;
      for (const auto& f : kFaces) {
        const Vec3 &p = x_[tetrahedra_[t][f[0]]], &q = x_[tetrahedra_[t][f[1]]], &r = x_[tetrahedra_[t][f[2]]];
        area = std::max(area, (q - p).cross(r - p).squaredNorm());
      }
      smallest = std::min(smallest, volume / std::sqrt(area));
    }
    return smallest;
  }

  const ImplicitSolid& solid_;
  std::vector<Vec3>& x_;
  const std::vector<std::array<Index, 4>>& tetrahedra_;
  std::vector<std::vector<Index>> tetrahedra_at_;  ///< tetrahedra at each vertex
  std::vector<std::vector<Index>> near_;           ///< neighbours of each vertex, towards whose centroid it moves
  std::vector<bool> surface_;
};

}  // namespace

void relax_tetrahedra(const ImplicitSolid& solid, std::vector<Vec3>& positions,
                      const std::vector<std::array<Index, 4>>& tetrahedra) {
  Relaxation relaxation(solid, positions, tetrahedra);
  for (int i = 0; i < kRounds; ++i) relaxation.round();
}

}  // namespace volccd
