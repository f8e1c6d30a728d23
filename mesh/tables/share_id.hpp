// Tests whether two short blocks of ids have a common id. This is the inner loop of Adjacency, which runs once per
// element pair; therefore it is inline.
#pragma once

#include <volccd/numerics/types.hpp>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace volccd::detail {

#if defined(__SSE2__)

/// A lane is all ones if one of the four ids of x is equal to an id of y: compares x with the four rotations of y.
inline __m128i match4(__m128i x, __m128i y) {
  const __m128i same0 = _mm_cmpeq_epi32(x, y);
  const __m128i same1 = _mm_cmpeq_epi32(x, _mm_shuffle_epi32(y, 0x39));
  const __m128i same2 = _mm_cmpeq_epi32(x, _mm_shuffle_epi32(y, 0x4E));
  const __m128i same3 = _mm_cmpeq_epi32(x, _mm_shuffle_epi32(y, 0x93));
  return _mm_or_si128(_mm_or_si128(same0, same1), _mm_or_si128(same2, same3));
}

inline __m128i load4(const Index* ids) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(ids)); }

/// Whether the blocks a and b of N ids have a common id, N = 4 or 8.
template <int N>
bool share_id(const Index* a, const Index* b) {
  static_assert(N == 4 || N == 8);
  __m128i match = match4(load4(a), load4(b));
  if constexpr (N == 8) {
    const __m128i a1 = load4(a + 4), b1 = load4(b + 4);
    match = _mm_or_si128(match, match4(a1, load4(b)));
    match = _mm_or_si128(match, _mm_or_si128(match4(load4(a), b1), match4(a1, b1)));
  }
  return _mm_movemask_epi8(match) != 0;
}

#else

template <int N>
bool share_id(const Index* a, const Index* b) {
  bool match = false;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j) match |= a[i] == b[j];
  return match;
}

#endif

}  // namespace volccd::detail
