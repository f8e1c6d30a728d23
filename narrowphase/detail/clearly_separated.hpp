// The first pass of the `inclusion` narrow phase over tests with a separation or with three control points: a vector
// kernel that drops the tests whose features are clearly further apart than the separation.
#pragma once

#include <cstdint>
#include <span>

#include <volccd/query/test_block.hpp>

namespace volccd::detail {

/// The gap of a clearly separated test along an axis L exceeds the separation times |L| by at least this factor times
/// |L|_1 and the greatest extent. This is much more than the rounding errors, so that the search of `inclusion` would
/// not leave such a test undecided.
inline constexpr double kClearMargin = 0x1p-10;

/// Sets keep[i] to 0 for tests whose features, for the given doubles, are further apart than the separation throughout
/// the step: by more than kClearMargin / 2 times the greatest coordinate difference to point 0. The flags of other
/// tests do not change. The axes are x, y, z, and, for tests that these do not drop, the direction between the closest
/// points at the middle of the step. Derivation: docs/numerics.md, "Clearly separated tests".
///
/// The answer for a test does not depend on the other tests, and has the same bits for every vector length. Two or
/// three control points. Pre: coordinates finite, separation >= 0, keep.size() >= block.padded_size().
void drop_clearly_separated(const TestBlock& block, double separation, std::span<std::uint8_t> keep);

}  // namespace volccd::detail
