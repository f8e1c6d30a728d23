#include <volccd/broadphase/candidate_pairs.hpp>

#include <algorithm>

namespace volccd {

void visit_candidates(const BroadPhase& broad_phase, const Step& step, StageState& state, Executor& executor,
                      FunctionRef<void(std::span<const ElementPair> pairs, unsigned worker)> visit) {
  const std::size_t blocks = broad_phase.blocks(step, state, executor);
  std::vector<Work> work(executor.workers());
  executor.parallel_for(blocks, 1, [&](std::size_t begin, std::size_t end, unsigned worker) {
    std::vector<ElementPair>& pairs = work[worker].pairs;
    for (std::size_t block = begin; block < end; ++block) {
      broad_phase.run(step, state, worker, block, work[worker]);
      if (!pairs.empty()) visit(pairs, worker);
      pairs.clear();
    }
  });
}

std::vector<ElementPair> candidate_pairs(const BroadPhase& broad_phase, const Step& step, StageState& state,
                                         Executor& executor) {
  std::vector<std::vector<ElementPair>> of_worker(executor.workers());
  visit_candidates(broad_phase, step, state, executor, [&](std::span<const ElementPair> pairs, unsigned worker) {
    of_worker[worker].insert(of_worker[worker].end(), pairs.begin(), pairs.end());
  });
  std::vector<ElementPair> all;
  for (const std::vector<ElementPair>& pairs : of_worker) all.insert(all.end(), pairs.begin(), pairs.end());
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace volccd
