// Mutations of mesh scripts by whole operations. libFuzzer's own ones insert and erase bytes, after which all
// operations that follow have other arguments.
#include <algorithm>

#include <volccd/core/random.hpp>

#include "fuzz/mesh_script.hpp"

extern "C" {
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed);
}

namespace volccd::fuzz {

namespace {

using Operations = std::vector<std::vector<std::uint8_t>>;

Operations operations_of(Bytes bytes) {
  MeshScript script(bytes);
  while (script.next_step()) {
  }
  Operations result;
  for (const Bytes operation : script.operations_read()) result.emplace_back(operation.begin(), operation.end());
  return result;
}

/// Changes an argument by a little, or to any value. The opcode is kept, so that most others keep their places.
void change_argument(std::vector<std::uint8_t>& operation, Random& random) {
  if (operation.size() < 2) return;
  std::uint8_t& argument = operation[1 + random.below(operation.size() - 1)];
  constexpr int kSteps[] = {-16, -4, -1, 1, 4, 16};
  argument = static_cast<std::uint8_t>(random.below(3) == 0 ? random.below(256)
                                                            : argument + kSteps[random.below(std::size(kSteps))]);
}

void mutate_once(Operations& all, Random& random) {
  const std::size_t i = random.below(all.size()), j = random.below(all.size());
  switch (random.below(8)) {
    case 0: all.erase(all.begin() + static_cast<std::ptrdiff_t>(i)); break;
    case 1: all.insert(all.begin() + static_cast<std::ptrdiff_t>(i), std::vector(all[j])); break;
    case 2: std::swap(all[i], all[j]); break;
    case 3: {  // one more operation, with room for its arguments
      std::vector<std::uint8_t> operation(1 + random.below(8));
      for (std::uint8_t& byte : operation) byte = static_cast<std::uint8_t>(random.below(256));
      all.insert(all.begin() + static_cast<std::ptrdiff_t>(i), std::move(operation));
      break;
    }
    default: change_argument(all[i], random); break;
  }
}

/// Other motions of the same meshes: new random displacements instead of the old ones, or before each step.
void change_motions(Operations& all, Random& random) {
  const auto displacements = [&] {
    const std::uint64_t size = random.below(6);  // of a cell of 16 to 128
    return std::vector<std::uint8_t>{MeshScript::kJitter, static_cast<std::uint8_t>(random.below(8) == 0 ? 1 : 0),
                                     static_cast<std::uint8_t>(random.below(256)),
                                     static_cast<std::uint8_t>((2 << size) + random.below(4))};
  };
  Operations result;
  for (std::vector<std::uint8_t>& operation : all) {
    const std::uint8_t opcode = operation[0];
    if (opcode == MeshScript::kJitter && random.below(2) == 0) continue;
    if (opcode == MeshScript::kStep && random.below(4) != 0) result.push_back(displacements());
    result.push_back(std::move(operation));
  }
  all = std::move(result);
}

}  // namespace

}  // namespace volccd::fuzz

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed) {
  using namespace volccd::fuzz;
  volccd::Random random(seed);
  if (random.below(4) == 0) return LLVMFuzzerMutate(data, size, max_size);
  Operations all = operations_of({data, size});
  if (all.empty()) return LLVMFuzzerMutate(data, size, max_size);
  if (random.below(2) == 0)
    change_motions(all, random);
  else
    for (std::uint64_t n = 1 + random.below(4); n > 0 && !all.empty(); --n) mutate_once(all, random);
  std::vector<std::uint8_t> bytes;
  for (const auto& operation : all) bytes.insert(bytes.end(), operation.begin(), operation.end());
  bytes.resize(std::min(bytes.size(), max_size));
  std::copy(bytes.begin(), bytes.end(), data);
  return bytes.size();
}
