#pragma once

namespace volccd::test {

inline constexpr int kRankNumbers[] = {1, 2, 3, 4, 7, 16, 64};

}  // namespace volccd::test
