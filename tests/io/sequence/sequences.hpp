// Sequences to write and to read again.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <volccd/io/sequence/writer.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "support/scratch_folder.hpp"

namespace volccd::test {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// All data of a sequence in memory, in the order of its file.
struct Sequence {
  struct Step {
    double time;
    std::vector<Vec3> points, velocity;
    SequenceCells cells;
    std::vector<double> thickness;
  };
  std::vector<std::int64_t> point_ids;
  std::vector<Step> steps;

  void write(const std::string& file, const SequenceMetadata& metadata = {}) const {
    SequenceWriter writer(file, point_ids, metadata);
    for (const Step& s : steps) writer.write_frame(s.time, s.points, s.cells, {s.velocity, s.thickness});
    writer.finish();
  }
};

/// Mixed cells that are removed, added again and changed under their ids; point ids with gaps, shuffled on request;
/// velocity and thickness depending on the seed; several steps that share their cells.
inline Sequence random_sequence(std::uint64_t seed, int steps = 6, bool shuffled_ids = true) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::uint64_t n) { return random() % n; };
  const auto real = [&] { return std::ldexp(static_cast<double>(static_cast<std::int64_t>(random())), -60); };
  const Shape shape = permuted(mixed_block(1 + static_cast<int>(below(2)), 1), seed);
  Sequence sequence;
  const std::size_t n = shape.positions.size();
  for (std::size_t i = 0; i < n; ++i) sequence.point_ids.push_back(static_cast<std::int64_t>(7 + 3 * i + below(3)));
  if (shuffled_ids) std::shuffle(sequence.point_ids.begin(), sequence.point_ids.end(), random);

  std::vector<ElementSpec> all = shape.elements;
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].id = static_cast<std::int64_t>(1000 + 5 * i);
    all[i].object = static_cast<std::int32_t>(i % 3);
  }
  const bool velocity = below(2) == 0, thickness = below(2) == 0;
  double time = real();
  for (int k = 0; k < steps; ++k) {
    Sequence::Step step;
    step.time = time;
    time += 0.125 + static_cast<double>(below(8));
    for (std::size_t i = 0; i < n; ++i) {
      step.points.push_back(shape.positions[i] + 0.1 * Vec3(real(), real(), real()));
      if (velocity) step.velocity.emplace_back(real(), real(), real());
    }
    if (k > 0 && below(3) == 0) {
      step.cells = sequence.steps.back().cells;
    } else {
      std::shuffle(all.begin(), all.end(), random);
      for (ElementSpec& spec : all) {
        if (below(8) == 0) spec.object = static_cast<std::int32_t>(below(4));
        // Quads and hexahedra that are rotated have other diagonals.
        if (below(8) == 0 && spec.type == ElementType::quad)
          std::rotate(spec.vertices.begin(), spec.vertices.begin() + 1, spec.vertices.end());
        if (below(6) != 0 || (&spec == &all.back() && step.cells.size() == 0)) step.cells.add(spec);
      }
    }
    if (thickness)
      for (std::size_t i = 0; i < step.cells.size(); ++i) step.thickness.push_back(std::abs(real()));
    sequence.steps.push_back(std::move(step));
  }
  return sequence;
}

}  // namespace volccd::test
